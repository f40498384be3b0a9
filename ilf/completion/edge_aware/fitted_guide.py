"""The guide of a frame in metres, and the belief in it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.blocks import Block, Box
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame
from ...data.guide import Gives
from ...data.pixel_grids import nearest_values
from .guide_curve import Array, Mask, fit_slow_field, fitted, sharpen, smoothest_surface, sums_of_cells, weighted_median

Values = NDArray[np.float64]

# Belief in a guide: a hold-out of known depth in areas, completed with the guide and without.

_PIXELS = 20_000
"""Approximate number of pixels of the hold-out test, on a lattice in the frame."""

_CELLS = 1500
"""Approximate number of cells of the completed surfaces."""

_TILES = 8
"""Hidden areas are squares; this many fit into the frame's width."""

_FOLDS = 4
"""Number of folds; every area is hidden in one of them."""

_SLOPE, _BENDING = 0.03, 0.1
"""Smoothness weights of the surfaces [per pixel of the lattice]."""

_FRAME = 60.0
"""Weight of the whole frame in the belief for a block, in cells."""

_LEAST_GAIN = 0.1
"""Minimum share by which a guide must reduce the error to be followed."""


@dataclass(frozen=True, eq=False)
class GuideTest:
    """Result of the hold-out test for every cell with hidden depth.

    Attributes
    ----------
    rows, columns : ndarray of int, shape (N,)
        The frame's pixel at the centre of the cell.
    weights : ndarray of float64, shape (N,)
        Number of known pixels.
    without : ndarray of float64, shape (N,)
        Known depth minus completed depth without the guide [m].
    change : ndarray of float64, shape (N,)
        Completed depth with the guide minus that without it [m].
    """

    rows: NDArray[np.intp]
    columns: NDArray[np.intp]
    weights: Values
    without: Values
    change: Values

    def belief(self, mask: Mask | None = None) -> float:
        """The weight of the guided surface, from 0 to 1, with the smallest mean error: in the frame, or in the pixels
        of a mask, bool (H, W), with the frame as a prior."""
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
        # the sum of absolute errors is minimal at this median
        best = weighted_median(self.without[moved] / self.change[moved], pull[moved])
        best = min(max(best, 0.0), 1.0)
        before, after = (float(np.sum(weights * np.abs(self.without - share * self.change))) for share in (0.0, best))
        return best if after < (1 - _LEAST_GAIN) * before else 0.0


def evaluate_guide(values: Array, depth: Array, confidence: Array, gives: Gives | None = None) -> GuideTest:
    """Hide known depth in areas and complete it with a guide and without: by a smooth surface relative to the fitted
    guide, or relative to the slowly varying surface of the known depth.

    Parameters
    ----------
    values, depth, confidence : ndarray of float32, shape (H, W)
    gives : str, optional
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
        plain = np.exp(fit_slow_field(logarithms, left.astype(np.float32)))
        guide = fitted(values, seen, confidence, gives)
        guided = plain + np.where(np.isfinite(guide), confidence * (guide - plain), np.float32(0))
        asked = sums_of_cells(hidden.astype(np.float32), cell)
        places = np.nonzero(asked)
        without, with_it = (_error(depth, base, left, hidden, cell)[places] / asked[places] for base in (plain, guided))
        parts.append((*places, asked[places], without, without - with_it))
    if not parts:
        nothing = np.zeros(0)
        return GuideTest(nothing.astype(np.intp), nothing.astype(np.intp), nothing, nothing, nothing)
    rows, columns, weights, without, change = (np.concatenate(found) for found in zip(*parts, strict=True))
    middle = cell * stride // 2
    return GuideTest(
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
    """Hidden depth minus completed depth, summed over cells."""
    counts, asked = (sums_of_cells(mask.astype(np.float32), cell) for mask in (left, hidden))
    totals, wanted = (sums_of_cells(np.where(mask, depth - base, np.float32(0)), cell) for mask in (left, hidden))
    return wanted - asked * smoothest_surface(counts, totals, _SLOPE, _BENDING / cell**2)


# The guide in metres, and the weight with which it is followed.

_SUFFICIENT = 0.5
"""Minimum weight of the guide at every pixel of a block that is completed from it alone."""


@dataclass(frozen=True, eq=False)
class FittedGuide:
    """A guide in metres.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        The guide, fitted to the known depth [m]; NaN where it has no value.
    confidence : ndarray of float32, shape (H, W)
        Its confidence, 0 where it has no value.
    test : GuideTest
    """

    depth: Array
    confidence: Array
    test: GuideTest

    @property
    def belief(self) -> float:
        """The belief for the whole frame, 0-1."""
        return self.test.belief()

    def to_text(self) -> str:
        """The belief as text for the user."""
        belief = self.belief
        if belief == 0:
            return "not used: it does not reduce the error of a hold-out of known depth"
        return f"followed to {belief:.0%} on average, by a hold-out of known depth"

    def suffices_for(self, block: Block) -> bool:
        """Whether it can replace the known depth that a block lacks."""
        return float(self.shares(block, block.box)[block.mask].min()) >= _SUFFICIENT

    def shares(self, block: Block, box: Box) -> Array:
        """Its weight for a block, 0-1, at the pixels of a box."""
        mask = np.zeros(self.depth.shape, bool)
        mask[block.box] = block.mask
        return np.float32(self.test.belief(mask)) * self.confidence[box]


@once_per_frame
def fit_guide(frame: RGBDFrame) -> FittedGuide:
    """Fit the frame's guide to all known depth and test it. Computed once per frame.

    Parameters
    ----------
    frame : RGBDFrame
        With a guide.
    """
    guide = frame.guide
    assert guide is not None
    has_value = np.isfinite(guide.values)
    if guide.confidence is None:
        confidence = has_value.astype(np.float32)
    else:
        confidence = np.where(has_value, guide.confidence, np.float32(0))
    values = np.where(has_value, sharpen(nearest_values(guide.values, has_value, 3)[1]), np.float32(np.nan))
    return FittedGuide(
        fitted(values, frame.depth, confidence, guide.gives),
        confidence,
        evaluate_guide(values, frame.depth, confidence, guide.gives),
    )
