"""Accuracy of the propagation of blocks from frame to frame."""
