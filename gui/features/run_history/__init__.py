"""Run history of a frame."""
