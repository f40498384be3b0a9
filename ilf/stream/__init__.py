"""Streams of frames: completed as they come, with what earlier frames have shown."""
