"""Inspection: depth profile along a line, statistics of a surface, distances and angles."""
