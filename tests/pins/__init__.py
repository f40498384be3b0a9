"""What the program does, pinned bit for bit between two states of the code on one machine: `python -m tests.pins`."""
