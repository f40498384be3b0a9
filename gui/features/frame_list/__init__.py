"""List of frames."""
