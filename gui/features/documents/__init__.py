"""Opening, exporting and closing frames, and blocks from and to files."""
