"""Damaged files of every format that the program reads, made at random from sound ones: what reading them leads to."""
