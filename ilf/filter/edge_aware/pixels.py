"""From surfaces on grids to the pixels of a block."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...blocks import Block, Box, union, within
from ...frame import RGBDFrame
from .grid import Level

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Pixels:
    """Brings surfaces from any grid to pixels of the block: holds no more for it, since it lives as long as snapshots.

    `places` are those of the pixels in the window, `seen` those among the block's pixels.
    """

    levels: tuple[Level, ...]
    places: NDArray[np.intp]
    seen: NDArray[np.intp]
    trend: Array
    frame: RGBDFrame
    block: Block

    @classmethod
    def of(
        cls,
        frame: RGBDFrame,
        block: Block,
        window: Box,
        levels: tuple[Level, ...],
        trend: Array,
        changing: bool = False,
    ) -> Pixels:
        """The block's pixels in a window, all or those without depth, for surfaces on grids of these levels and a trend
        on the window."""
        around = union(block.box, window)
        mask = np.zeros(tuple(side.stop - side.start for side in around), bool)
        mask[within(block.box, around)] = block.mask
        inside = mask[within(window, around)]
        among = inside & np.isnan(frame.depth[window]) if changing else inside
        places = np.flatnonzero(among)
        seen = np.flatnonzero(seen_in(block, window))[among[inside]]
        return cls(levels, places, seen, trend.ravel()[places], frame, block)

    @property
    def nbytes(self) -> int:
        """Memory of what is not the frame's or the block's."""
        return self.places.nbytes + self.seen.nbytes + self.trend.nbytes

    def on(self, surface: Array) -> Array:
        """A surface on the window, at the pixels."""
        return surface.ravel()[self.places]

    def on_block(self, coarseness: int, held: Array) -> NDArray[np.float64]:
        """Depth [m] at all of the block's pixels, raw where a surface is not held: it is less the trend, and on a grid
        so many above the finest, or at the pixels."""
        u = held
        for coarser, finer in pairwise(reversed(self.levels[: coarseness + 1])):
            u = coarser.enlarged(u, finer)
        result = self.frame.depth[self.block.box][self.block.mask].astype(np.float64)
        result[self.seen] = (self.on(u) if coarseness else u) + self.trend
        return result


def seen_in(block: Block, window: Box) -> NDArray[np.bool_]:
    """Which of a block's pixels lie in a window, in the order of `block.mask`'s True values."""
    rows, columns = (
        slice(max(a.start - b.start, 0), max(a.stop - b.start, 0)) for a, b in zip(window, block.box, strict=True)
    )
    seen = np.zeros(block.mask.shape, bool)
    seen[rows, columns] = True
    return seen[block.mask]
