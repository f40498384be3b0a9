"""The table of operation blocks."""
