"""Projects: the work on frames, kept whole. `frame_state.py` has what is kept of a frame."""
