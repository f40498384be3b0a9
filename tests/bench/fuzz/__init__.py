"""Fuzz test of all readers: randomly damaged files of every format that the program reads."""
