"""Benches and training: nothing that completing a frame needs."""
