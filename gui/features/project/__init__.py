"""Projects: opening, saving, closing, recovery, and recent files."""
