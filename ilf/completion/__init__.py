"""ILF: the two filters, the learned correction, extrapolation and the expected error."""
