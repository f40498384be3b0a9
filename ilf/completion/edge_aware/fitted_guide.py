"""The guide of a frame as the filter follows it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Block, Box
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.pixel_grids import nearest_values
from .guide_curve import Array, Mask, fitted, sharpened, slow, smoothest, sums_of_cells, weighted_median

Values = NDArray[np.float64]

# How far a guide is to be believed: known depth is hidden in areas, and completed with the guide and without.

_PIXELS = 20_000
"""The test is made on a part of the frame's pixels, a lattice of about so many."""

_CELLS = 1500
"""Surfaces are completed on a grid of about so many cells."""

_TILES = 8
"""Areas that are hidden are squares with a side of the frame's width over this."""

_FOLDS = 4
"""Every area is hidden once, in so many turns."""

_SLOPE, _BENDING = 0.03, 0.1
"""Weights of the surfaces' smoothness [per pixel of the lattice]."""

_FRAME = 60.0
"""In what is said of a block, the whole frame weighs as much as so many of its cells."""

_LEAST_GAIN = 0.1
"""A guide that takes off no larger share of the error is not believed."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What came of hiding known depth, for every cell of it.

    Attributes
    ----------
    rows, columns : ndarray of int, shape (N,)
        The frame's pixel in the middle of the cell.
    weights : ndarray of float64, shape (N,)
        How much known depth there is.
    without : ndarray of float64, shape (N,)
        Known depth less what comes back without the guide [m].
    change : ndarray of float64, shape (N,)
        What comes back with the guide less what comes back without it [m].
    """

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    weights: Values
    without: Values
    change: Values

    def belief(self, mask: Mask | None = None) -> float:
        """How far to go from the surface without the guide, 0, to the one with it, 1, so that the mean error is least:
        in the frame, or in the pixels of a mask, bool (H, W), which it is a prior for then."""
        whole = self._best(self.weights)
        if mask is None or whole == 0.0:
            return whole
        own = self.weights * mask[self.rows, self.columns]
        return self._best(own + _FRAME / self.weights.size * self.weights)

    def _best(self, weights: Values) -> float:
        pull = weights * np.abs(self.change)
        moved = pull > 0
        if not moved.any():
            return 0.0
        # the sum of absolute errors is least at this median
        best = weighted_median(self.without[moved] / self.change[moved], pull[moved])
        best = min(max(best, 0.0), 1.0)
        before, after = (float(np.sum(weights * np.abs(self.without - share * self.change))) for share in (0.0, best))
        return best if after < (1 - _LEAST_GAIN) * before else 0.0


def try_guide(values: Array, depth: Array, confidence: Array) -> Trial:
    """Hide known depth in areas, and complete it with a guide and without: by a surface that is smooth, less the fitted
    guide, or less the slow surface that known depth lies on.

    Parameters
    ----------
    values, depth, confidence : ndarray of float32, shape (H, W)
        As for `fitted`.
    """
    height, width = depth.shape
    stride = max(1, round(math.sqrt(depth.size / _PIXELS)))
    lattice = np.s_[stride // 2 :: stride, stride // 2 :: stride]
    values, depth, confidence = values[lattice], depth[lattice], confidence[lattice]
    cell = max(1, math.ceil(math.sqrt(depth.size / _CELLS)))
    known = np.isfinite(depth)
    parts = []
    for area in _areas(depth.shape, cell):
        hidden, left = known & area, known & ~area
        if not left.any() or not hidden.any():
            continue
        seen = np.where(left, depth, np.float32(np.nan))
        logarithms = np.log(np.where(left, depth, np.float32(1)))
        plain = np.exp(slow(logarithms, left.astype(np.float32)))
        guide = fitted(values, seen, confidence)
        guided = plain + np.where(np.isfinite(guide), confidence * (guide - plain), np.float32(0))
        asked = sums_of_cells(hidden.astype(np.float32), cell)
        places = np.nonzero(asked)
        without, with_it = (_error(depth, base, left, hidden, cell)[places] / asked[places] for base in (plain, guided))
        parts.append((*places, asked[places], without, without - with_it))
    if not parts:
        nothing = np.zeros(0)
        return Trial(nothing.astype(np.intp), nothing.astype(np.intp), nothing, nothing, nothing)
    rows, columns, weights, without, change = (np.concatenate(found) for found in zip(*parts, strict=True))
    middle = cell * stride // 2
    return Trial(
        np.minimum(rows * cell * stride + middle, height - 1),
        np.minimum(columns * cell * stride + middle, width - 1),
        weights.astype(np.float64),
        without.astype(np.float64),
        change.astype(np.float64),
    )


def _areas(shape: tuple[int, ...], cell: int) -> Iterator[Mask]:
    side = max(cell, shape[1] // _TILES // cell * cell)
    rows, columns = (np.arange(size) // side for size in shape)
    turns = np.add.outer(rows, 2 * columns) % _FOLDS
    for turn in range(_FOLDS):
        yield turns == turn


def _error(depth: Array, base: Array, left: Mask, hidden: Mask, cell: int) -> Array:
    """Hidden depth less what comes back of it, summed over cells."""
    counts, asked = (sums_of_cells(mask.astype(np.float32), cell) for mask in (left, hidden))
    totals, wanted = (sums_of_cells(np.where(mask, depth - base, np.float32(0)), cell) for mask in (left, hidden))
    return wanted - asked * smoothest(counts, totals, _SLOPE, _BENDING / cell**2)


# The guide in metres, and how far to follow it.

_LEFT_ASIDE = "The guide was left aside: where known depth is hidden for a test, it does not come back better with it."

_CARRIES = 0.5
"""A guide that is followed so far at every pixel of a block is enough to complete it."""


@dataclass(frozen=True, eq=False)
class FittedGuide:
    """A guide in metres.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        What the guide says, fitted to the known depth [m]; NaN where it says nothing.
    confidence : ndarray of float32, shape (H, W)
        Its own, 0 where it says nothing.
    trial : Trial
    """

    depth: Array
    confidence: Array
    trial: Trial

    @property
    def belief(self) -> float:
        """How far the frame's known depth bears it out, 0-1."""
        return self.trial.belief()

    def in_words(self) -> str:
        """How far it is believed, for the user."""
        belief = self.belief
        if belief == 0:
            return "left aside: known depth that is hidden for a test does not come back better with it"
        return f"followed to {belief:.0%}, on the whole, by known depth that was hidden for a test"

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know of it."""
        return () if self.belief > 0 else (_LEFT_ASIDE,)

    def carries(self, block: Block) -> bool:
        """Whether it may stand for known depth that a block lacks."""
        return float(self.shares(block, block.box)[block.mask].min()) >= _CARRIES

    def shares(self, block: Block, box: Box) -> Array:
        """How far to follow it for a block, 0-1, at the pixels of a box."""
        mask = np.zeros(self.depth.shape, bool)
        mask[block.box] = block.mask
        return np.float32(self.trial.belief(mask)) * self.confidence[box]


@once_per_frame
def fit_guide(frame: RGBDFrame) -> FittedGuide | None:
    """The frame's guide in metres, and how far to believe it; None without one. Worked out once, of all known depth.

    Parameters
    ----------
    frame : RGBDFrame
    """
    guide = frame.guide
    if guide is None:
        return None
    said = np.isfinite(guide.values)
    if guide.confidence is None:
        confidence = said.astype(np.float32)
    else:
        confidence = np.where(said, guide.confidence, np.float32(0))
    values = np.where(said, sharpened(nearest_values(guide.values, said, 3)[1]), np.float32(np.nan))
    return FittedGuide(fitted(values, frame.depth, confidence), confidence, try_guide(values, frame.depth, confidence))
