"""Edits of a label map as pure functions. Each returns a patch to apply and revert, or None if nothing changes."""
