"""Sources of frames (folders, data sets, recordings, cameras) behind one interface."""
