"""The runs of a frame that are kept, side by side."""
