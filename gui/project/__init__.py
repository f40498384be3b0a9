"""The project of the window: its file, the stored states of frames, the autosave, and loading of frames."""
