"""Generated scenes to learn from: colour, exact depth, what a sensor makes of it, and where it jumps or bends."""
