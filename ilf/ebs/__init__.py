"""EBS, the extraction of boundaries and surfaces."""

from .extraction import Extraction, FoundBlocks, extract, extract_blocks, forget_stages, found_blocks

__all__ = ["Extraction", "FoundBlocks", "extract", "extract_blocks", "forget_stages", "found_blocks"]
