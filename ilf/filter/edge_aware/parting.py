"""What a border that was drawn by hand parts: links between neighbouring cells, on every grid of the pyramid.

On the finest grid, links from the block's drawn pixels out of the block are cut. A coarser cell that such a cut goes
through stands for its part in the block alone, so that nothing known beyond the cut gets into it; and two coarser
cells are linked if at least one link is left between what they stand for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..pyramid import enlarged

Mask = NDArray[np.bool_]
Array = NDArray[np.float32]

_SOME = 0.01
"""Shares are multiples of 1/16, but for rounding."""


@dataclass(frozen=True, eq=False)
class Parting:
    """The cuts on one grid.

    Attributes
    ----------
    inside : ndarray of bool, shape (H, W)
        Cells of the block.
    right, down : ndarray of bool, shape (H, W)
        Whether a cell is linked to the next one along x, and along y; True in the last column, and row.
    """

    inside: Mask
    right: Mask
    down: Mask

    @classmethod
    def around(cls, inside: Mask, drawn: Mask) -> Parting | None:
        """On the finest grid: the block's pixels, and those of them whose links out of the block are cut; None if there
        are no such links."""
        right, down = np.ones_like(inside), np.ones_like(inside)
        for values, at, linked in ((inside, drawn, right), (inside.T, drawn.T, down.T)):
            out = values & at
            linked[:, :-1] = (values[:, 1:] == values[:, :-1]) | ~(out[:, 1:] | out[:, :-1])
        return None if right.all() and down.all() else cls(inside, right, down)

    @property
    def kept(self) -> Mask:
        """Cells that count in the next level: all but those beyond a cut through the larger cell that they are in."""
        right, down = _even(self.right), _even(self.down)
        whole = right[::2, ::2] & right[1::2, ::2] & down[::2, ::2] & down[::2, 1::2]
        height, width = self.inside.shape
        return self.inside | whole.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]

    def halved(self) -> Parting:
        """On the next level: cells of twice the size."""
        inside, kept = _even(self.inside), _even(self.kept)
        right, down = _even(self.right) & kept, _even(self.down) & kept
        right[:, :-1] &= kept[:, 1:]
        down[:-1] &= kept[1:]
        return Parting(
            inside[::2, ::2] | inside[1::2, ::2] | inside[::2, 1::2] | inside[1::2, 1::2],
            _last_open(right[::2, 1::2] | right[1::2, 1::2]),
            _last_open((down[1::2, ::2] | down[1::2, 1::2]).T).T,
        )

    def cut(self, smooth_x: Array, smooth_y: Array) -> tuple[Array, Array]:
        """How much smoothness is left between neighbours along x and y, none across the cuts."""
        return smooth_x * self.right[:, :-1], smooth_y * self.down[:-1]

    def enlarged(self, values: Array, finer: Parting) -> Array:
        """Values on this grid on the next finer one, bilinearly, block and the rest each from its own cells."""
        shape = finer.inside.shape
        # the rest, where all that it could take its value from stands for the block: the block's value will do
        result = enlarged(values, shape)
        for own, here in ((self.inside, finer.inside), (~self.inside, ~finer.inside)):
            share = enlarged(own.astype(np.float32), shape)
            total = enlarged(np.where(own, values, np.float32(0)), shape)
            np.divide(total, share, out=result, where=here & (share > _SOME))
        return result


def _even(values: Mask) -> Mask:
    """Odd sides completed by their last row or column."""
    return np.pad(values, [(0, size % 2) for size in values.shape], mode="edge")


def _last_open(linked: Mask) -> Mask:
    linked[:, -1] = True
    return linked
