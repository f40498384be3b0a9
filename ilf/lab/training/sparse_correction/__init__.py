"""Training of the correction network for sparse depth on real frames."""
