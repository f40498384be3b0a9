"""The project of the window: its file, the stored states of frames, and the autosave."""
