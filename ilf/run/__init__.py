"""One run, from frame to files: its inputs, record, replay and output files."""
