"""EBS, the extraction of boundaries and surfaces."""

from .extraction import Extraction, extract, extract_blocks
from .strength import edge_strength

__all__ = ["Extraction", "edge_strength", "extract", "extract_blocks"]
