"""The default's filter: a low pass that lets go at edges."""
