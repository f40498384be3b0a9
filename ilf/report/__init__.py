"""Reports of frames: one self-contained HTML page each, or one of many."""
