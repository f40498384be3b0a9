"""Propagation of blocks from frame to frame."""
