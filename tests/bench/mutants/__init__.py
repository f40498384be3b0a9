"""Deliberate faults in the program, and how many of them the tests find."""
