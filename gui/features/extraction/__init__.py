"""Extraction of blocks: parameters, the view of its stages, and extraction on request."""
