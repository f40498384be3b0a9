"""How far filled depth may be off, and where no measurement supports it."""
