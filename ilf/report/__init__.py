"""Reports: one self-contained HTML page about one frame or several."""
