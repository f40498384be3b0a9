"""How well blocks follow from frame to frame."""
