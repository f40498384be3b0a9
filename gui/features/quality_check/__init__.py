"""Places where blocks and depth look wrong, one after the other; invalid depth is suggested."""
