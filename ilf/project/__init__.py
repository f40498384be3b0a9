"""Projects: frames with all edits and results. `frame_state.py` defines the stored state of a frame."""
