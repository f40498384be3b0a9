"""Levels of the pyramid over a block's window, and the interpolation of surfaces to the next finer level."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Block, Box, union, within
from ...data.frame import RGBDFrame
from ...data.pixel_grids import enlarged, largest_of_four, sums_of_four
from .smoothness import Sums, Weights, make_weights, tally

Mask = NDArray[np.bool_]
Array = NDArray[np.float32]

# Cut links: links across a border that was drawn by hand, on every grid of the pyramid.
#
# On the finest grid, links from the block's drawn pixels out of the block are cut. A coarser cell with a cut through it
# represents only its part in the block, so that it contains no depth from beyond the cut; two coarser cells are linked
# if at least one link is left between the parts that they represent.

_SOME = 0.01
"""Threshold for shares, which are multiples of 1/16 except for rounding."""


@dataclass(frozen=True, eq=False)
class CutLinks:
    """The cut links of one grid.

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
    def around(cls, inside: Mask, drawn: Mask) -> CutLinks | None:
        """Cut links on the finest grid, from the block's pixels and those with a drawn border; None without any."""
        right, down = np.ones_like(inside), np.ones_like(inside)
        for values, at, linked in ((inside, drawn, right), (inside.T, drawn.T, down.T)):
            out = values & at
            linked[:, :-1] = (values[:, 1:] == values[:, :-1]) | ~(out[:, 1:] | out[:, :-1])
        return None if right.all() and down.all() else cls(inside, right, down)

    @property
    def kept(self) -> Mask:
        """Cells used in the next level: all except those beyond a cut through the larger cell that contains them."""
        right, down = _even(self.right), _even(self.down)
        whole = right[::2, ::2] & right[1::2, ::2] & down[::2, ::2] & down[::2, 1::2]
        height, width = self.inside.shape
        return self.inside | whole.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]

    @property
    def uncut(self) -> Mask:
        """Cells with all of their links."""
        result = self.right & self.down
        result[:, 1:] &= self.right[:, :-1]
        result[1:] &= self.down[:-1]
        return result

    def halved(self) -> CutLinks:
        """The cut links of the next level, with cells of twice the size."""
        inside, kept = _even(self.inside), _even(self.kept)
        right, down = _even(self.right) & kept, _even(self.down) & kept
        right[:, :-1] &= kept[:, 1:]
        down[:-1] &= kept[1:]
        return CutLinks(
            inside[::2, ::2] | inside[1::2, ::2] | inside[::2, 1::2] | inside[1::2, 1::2],
            _last_open(right[::2, 1::2] | right[1::2, 1::2]),
            _last_open((down[1::2, ::2] | down[1::2, 1::2]).T).T,
        )

    def cut(self, weights: Weights) -> None:
        """Set the weights of differences across the cuts to 0."""
        for slope, bend, linked in (
            (weights.slope_x, weights.bend_x, self.right[:, :-1]),
            (weights.slope_y.T, weights.bend_y.T, self.down[:-1].T),
        ):
            slope *= linked
            bend *= linked[:, 1:] & linked[:, :-1]

    def enlarged(self, values: Array, finer: CutLinks) -> Array:
        """Interpolate values bilinearly to the next finer grid, block and rest each from its own cells."""
        shape = finer.inside.shape
        # cells outside the block with no source cell of their own keep the block's value
        result = enlarged(values, shape)
        for own, here in ((self.inside, finer.inside), (~self.inside, ~finer.inside)):
            share = enlarged(own.astype(np.float32), shape)
            total = enlarged(np.where(own, values, np.float32(0)), shape)
            np.divide(total, share, out=result, where=here & (share > _SOME))
        return result


def _even(values: Mask) -> Mask:
    """Pad odd sides by repeating the last row or column."""
    return np.pad(values, [(0, size % 2) for size in values.shape], mode="edge")


def _last_open(linked: Mask) -> Mask:
    linked[:, -1] = True
    return linked


# The pyramid: grids, and the interpolation of surfaces to the next finer one.


class Level(NamedTuple):
    """The properties of a grid needed to interpolate surfaces to the next finer one."""

    shape: tuple[int, ...]
    cut_links: CutLinks | None

    def enlarged(self, u: Array, finer: Level) -> Array:
        """Interpolate a surface to the next finer grid."""
        if self.cut_links is None or finer.cut_links is None:
            return enlarged(u, finer.shape)
        return self.cut_links.enlarged(u, finer.cut_links)


@dataclass(frozen=True, eq=False)
class Grid:
    """A level of the pyramid over the window.

    `counts` and `totals` are the number and sum of the known depth minus the trend, in which depth of neighbours and by
    hand counts with its weight; `inside` is the number of the block's pixels in every cell; `smooth` is the smallest
    smoothness there, 1 to 0 at an edge, `creases` the largest probability of a crease, or None if unknown. `held_out`
    contains counts and totals of the held-out depth, or None; `carried` weights and totals of depth carried from
    another frame, or None; `cut_links` the links cut by a drawn border, or None.
    """

    cell: int
    counts: Array
    totals: Array
    inside: Array
    trend: Array
    smooth: Array
    creases: Array | None
    held_out: tuple[Array, Array] | None
    carried: tuple[Array, Array] | None
    cut_links: CutLinks | None

    @property
    def coarseness(self) -> int:
        """Number of levels above the finest."""
        return self.cell.bit_length() - 1

    @cached_property
    def samples(self) -> float:
        """Number of pixels with known depth or depth by hand, each with its weight."""
        return float(self.counts.sum(dtype=np.float64))

    @property
    def start(self) -> Array:
        """The cells' mean known depth minus the trend; 0 where there is none."""
        return np.divide(self.totals, self.counts, out=np.zeros_like(self.totals), where=self.counts > 0)

    def started(self, u: Array, coarser: Array) -> Array:
        """An initial surface: `u`, interpolated from the surface of the coarser grid, with the details of carried
        depth."""
        if self.carried is None:
            return u
        weights, totals = self.carried
        detailed = np.where(weights > 0, totals / np.maximum(weights, np.float32(1e-6)), u)
        return detailed + enlarged(coarser - np.float32(0.25) * sums_of_four(detailed, "edge"), u.shape)

    def sums(self, u: Array, previous: Array) -> Sums:
        """The sums of a step from `previous` to u."""
        return Sums(*tally(u, previous, self.inside, self.trend, self.counts, self.totals))

    def weights(self, slope: float, bending: float, out: Weights | None = None) -> Weights:
        """Weights of differences, see `make_weights`."""
        made = make_weights(self.smooth, slope, bending, self.creases, out)
        if self.cut_links is not None:
            self.cut_links.cut(made)
        return made

    @property
    def level(self) -> Level:
        """Its properties for interpolation."""
        return Level(self.counts.shape, self.cut_links)

    def halved(self) -> Grid:
        """The next level, with cells of twice the size."""
        counts, totals, smooth = self.counts, self.totals, self.smooth
        if self.cut_links is not None:
            kept = self.cut_links.kept
            counts, totals = (np.where(kept, values, np.float32(0)) for values in (counts, totals))
            smooth = np.where(kept, smooth, np.float32(1))
        return Grid(
            cell=2 * self.cell,
            counts=sums_of_four(counts),
            totals=sums_of_four(totals),
            inside=sums_of_four(self.inside),
            trend=np.float32(0.25) * sums_of_four(self.trend, "edge"),
            smooth=-largest_of_four(-smooth),
            creases=None if self.creases is None else largest_of_four(self.creases),
            held_out=self.held_out and (sums_of_four(self.held_out[0]), sums_of_four(self.held_out[1])),
            carried=self.carried and (sums_of_four(self.carried[0]), sums_of_four(self.carried[1])),
            cut_links=self.cut_links and self.cut_links.halved(),
        )


# Interpolation of surfaces on grids to the pixels of a block.


class Pixels:
    """Interpolates surfaces from any grid to pixels of the block; kept small, since snapshots refer to it."""

    def __init__(
        self,
        frame: RGBDFrame,
        block: Block,
        window: Box,
        levels: tuple[Level, ...],
        trend: Array,
        limits: tuple[float, float],
        chosen: Mask,
    ) -> None:
        """The chosen ones of the block's pixels in a window, for surfaces on grids of these levels, a trend in the
        window, and limits of their sum."""
        around = union(block.box, window)
        mask = np.zeros(tuple(side.stop - side.start for side in around), bool)
        mask[within(block.box, around)][block.mask] = chosen
        self._frame, self._block, self._levels, self._limits = frame, block, levels, limits
        self._places = np.flatnonzero(mask[within(window, around)])
        """Flat indices in the window."""
        self._seen = np.flatnonzero(pixels_in_window(block, window) & chosen)
        """The same among the block's pixels."""
        self._trend = trend.ravel()[self._places]

    @property
    def nbytes(self) -> int:
        """Memory without frame and block."""
        return self._places.nbytes + self._seen.nbytes + self._trend.nbytes

    def on(self, surface: Array) -> Array:
        """A surface of the window at the pixels."""
        return surface.ravel()[self._places]

    def depth(self, coarseness: int, held: Array) -> Array:
        """Depth [m] at the pixels. `held` is the surface minus trend: on the grid of this coarseness, or at the pixels
        if that is 0."""
        u = held
        for coarser, finer in pairwise(reversed(self._levels[: coarseness + 1])):
            u = coarser.enlarged(u, finer)
        return np.asarray(np.clip((self.on(u) if coarseness else u) + self._trend, *self._limits))

    def on_block(self, coarseness: int, held: Array) -> NDArray[np.float64]:
        """Depth [m] at all of the block's pixels, raw at those that were not chosen."""
        result = self._frame.depth[self._block.box][self._block.mask].astype(np.float64)
        result[self._seen] = self.depth(coarseness, held)
        return result


def pixels_in_window(block: Block, window: Box) -> NDArray[np.bool_]:
    """Which of a block's pixels lie in a window, in the order of `block.mask`'s True values."""
    rows, columns = (
        slice(max(a.start - b.start, 0), max(a.stop - b.start, 0)) for a, b in zip(window, block.box, strict=True)
    )
    seen = np.zeros(block.mask.shape, bool)
    seen[rows, columns] = True
    return seen[block.mask]
