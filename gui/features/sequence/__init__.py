"""Sequences of frames: playing them, and flicker."""
