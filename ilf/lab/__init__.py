"""Benches, the paper's experiments and training: nothing that completing a frame needs."""
