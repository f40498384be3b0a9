"""Where surfaces may end: edges from colour and known depth, for blocks and filter alike."""

from .frame_edges import FrameEdges, find_edges
from .strength import edge_strength

__all__ = ["FrameEdges", "edge_strength", "find_edges"]
