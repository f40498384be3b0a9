"""State of the window, without widgets; it changes only through `workspace.py`."""
