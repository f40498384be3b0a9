"""One run, from frame to files: what it is made of, its record, its replay and its files."""
