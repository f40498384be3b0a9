"""Propagation of blocks from one frame to the next."""
