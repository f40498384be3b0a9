"""Blocks of one frame carried to the next."""
