"""A place in a frame where its blocks, or its depth, look wrong."""

from __future__ import annotations

from dataclasses import dataclass

from ..blocks import Box

KINDS = ("jump", "surfaces", "border", "error", "island", "sliver", "carried")
"""Depth jumps inside a block; a block holds two surfaces; an edge is weak under a border, and a stronger one runs
beside it; high expected error; a part that is parted from its block or lies inside another; a thin part; a block
that came from another frame and needs a look."""


@dataclass(frozen=True)
class Place:
    """Where to look, and why.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    box : tuple of slice
        Rows and columns that it takes up.
    labels : tuple of int
        Blocks that it is about, the one to choose first; 0 stands for no block.
    point : tuple of float
        (x, y) in image coordinates: the pixel centre in the middle of it.
    score : float
        Harm that it may do: filled pixels times the error [m] in their depth. Places of all kinds compare by it.
    reason : str
        A sentence that says what is wrong; blocks are called by their numbers, as "Block 5".
    """

    kind: str
    box: Box
    labels: tuple[int, ...]
    point: tuple[float, float]
    score: float
    reason: str
