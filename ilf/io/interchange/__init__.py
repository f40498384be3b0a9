"""Blocks from and to the files of other programs: label PNG, labelme, COCO, folders and lists of masks."""

from .reading import read_blocks
from .stacking import LoadedBlocks
from .writing import BLOCK_FORMATS, write_blocks

__all__ = ["BLOCK_FORMATS", "LoadedBlocks", "read_blocks", "write_blocks"]
