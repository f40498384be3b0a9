"""Edges from colour and known depth."""
