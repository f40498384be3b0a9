"""Blocks go from frame to frame."""
