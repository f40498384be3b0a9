"""Training of the correction network of cells on real and path-traced frames."""
