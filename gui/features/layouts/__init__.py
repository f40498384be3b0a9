"""Layouts of the window: switching, saving and resetting them."""
