"""Projects: opening, saving, closing, and recovery."""
