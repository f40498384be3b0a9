"""Projects: opened, saved, closed, recovered, and what was opened last."""
