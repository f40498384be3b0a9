"""The edge-aware filter of the default preset: a low pass with links that weaken at edges."""
