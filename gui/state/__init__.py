"""What is worked on, without widgets; `workspace.py` is where it changes."""
