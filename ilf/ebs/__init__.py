"""EBS, the extraction of boundaries and surfaces."""

from .extraction import Extraction, extract, extract_blocks

__all__ = ["Extraction", "extract", "extract_blocks"]
