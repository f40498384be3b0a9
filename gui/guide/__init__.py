"""A guide of the frame: loading, following and removing it."""
