"""Expected error of filled depth, and where no measurement supports it."""
