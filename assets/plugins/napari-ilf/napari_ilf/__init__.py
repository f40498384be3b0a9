"""ILF Studio in napari: reading of frames, projects and results, and completion of depth layers."""
