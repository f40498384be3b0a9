"""Where surfaces may end: edges from colour and known depth, for blocks and filter alike."""

from .strength import edge_strength

__all__ = ["edge_strength"]
