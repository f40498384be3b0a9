"""What random walks from every pixel come upon: walks that hardly get across edges, and end at known depth.

Where known depth surrounds a pixel and agrees, walks are short and end at one depth. In a wide hole they are long;
beside a far surface and a near one they end at either; behind edges on all sides they hardly end at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..filter.banded import solve_grid

Array = NDArray[np.float32]

_CELLS = 6000
"""The grid of the walks has no more cells than that, of 2, 4, 8, ... px."""

_EDGE_SCALE = 0.13
"""Edge strength at which a step is e times less likely."""

_LEAST = 1e-4
"""Likelihood of a step across the strongest edge, and of giving up at any step: they have 1 / so many at most."""


@dataclass(frozen=True, eq=False)
class Walks:
    """Where the walks from every pixel end.

    Attributes
    ----------
    cells : ndarray of float32, shape (4, rows, columns)
        What is known at the cells: `depth`, `spread`, `steps` and `aside`, in this order. Pictures of the frame's size
        are only made of it when they are asked for.
    cell : int
        Side of a cell [px].
    shape : (int, int)
        Height and width of the frame [px].
    """

    cells: Array
    cell: int
    shape: tuple[int, int]

    @property
    def depth(self) -> Array:
        """Mean of the logarithm of the depth [m] that they end at, (H, W)."""
        return self._on_pixels(0)

    @property
    def spread(self) -> Array:
        """Standard deviation of that logarithm, (H, W)."""
        return self._on_pixels(1)

    @property
    def steps(self) -> Array:
        """How long they are, in steps of a cell, (H, W)."""
        return self._on_pixels(2)

    @property
    def aside(self) -> Array:
        """How far [px] the mean of the places where they end is from where they begin, (H, W): small in the middle of
        known depth, large where it lies on one side only."""
        return self._on_pixels(3)

    def _on_pixels(self, number: int) -> Array:
        """Values of cells at the pixels, bilinearly."""
        values, (height, width) = self.cells[number], self.shape
        size = values.shape[1] * self.cell, values.shape[0] * self.cell
        full = cv2.resize(values, size, interpolation=cv2.INTER_LINEAR)
        return np.asarray(full[:height, :width], np.float32)


def walk(depth: Array, edges: Array) -> Walks:
    """Walks over a frame with some known depth [m], NaN = missing, past edges of a strength in [0, 1]."""
    cell = 2
    while -(-depth.shape[0] // cell) * -(-depth.shape[1] // cell) > _CELLS:
        cell *= 2
    known = np.isfinite(depth)
    logarithm = np.log(depth, where=known, out=np.zeros_like(depth))
    middle = np.float32(logarithm.sum(dtype=np.float64) / np.count_nonzero(known))
    logarithm = np.where(known, logarithm - middle, np.float32(0))
    counts = _sums(known.astype(np.float32), cell)
    mean, square = (_sums(values, cell) / np.maximum(counts, 1) for values in (logarithm, logarithm * logarithm))
    rows, columns = np.indices(counts.shape)
    # known depth that fills a cell ends a walk there sooner than the walk would leave it
    ends = (counts / cell).astype(np.float64)
    hard = 1 / np.maximum(np.exp(-edges / np.float32(_EDGE_SCALE)), np.float32(_LEAST))
    along_x, along_y = _links(hard, cell), _links(np.ascontiguousarray(hard.T), cell).T
    wanted = np.stack([ends, np.ones_like(ends), *(ends * values for values in (mean, square, rows, columns))])
    arriving, steps, *gathered = _solve(along_x, along_y, ends + _LEAST, wanted)
    mean_end, square_end, row_end, column_end = (values / np.maximum(arriving, 1e-12) for values in gathered)
    spread = np.sqrt(np.maximum(square_end - mean_end**2, 0))
    aside = cell * np.hypot(row_end - rows, column_end - columns)
    height, width = depth.shape
    return Walks(np.stack([mean_end + middle, spread, steps, aside]).astype(np.float32), cell, (height, width))


def _sums(values: NDArray, cell: int) -> Array:
    """Sums over cells, float32 (rows of cells, columns of cells)."""
    height, width = values.shape
    whole = cv2.copyMakeBorder(values, 0, -height % cell, 0, -width % cell, cv2.BORDER_CONSTANT, value=0)
    return _means(whole, cell, cell) * np.float32(cell * cell)


def _links(hard: Array, cell: int) -> Array:
    """How easily walks get from a cell's middle to the next along x: by many ways, each as hard as its pixels."""
    height, width = hard.shape
    whole = cv2.copyMakeBorder(hard, 0, -height % cell, 0, -width % cell, cv2.BORDER_REPLICATE)
    after = cell // 2 + 1
    between = whole[:, after : whole.shape[1] - cell + after]
    if not between.size:
        return np.empty((whole.shape[0] // cell, 0), np.float32)
    return _means(1 / _means(between, cell, 1), 1, cell)


def _means(values: NDArray, width: int, height: int) -> Array:
    """Means over rectangles of so many pixels, of which there is a whole number."""
    size = values.shape[1] // width, values.shape[0] // height
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA), np.float32)


def _solve(
    along_x: Array, along_y: Array, ends: NDArray[np.float64], wanted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """What walks gather on the way, for every cell, of what they gather at each step, (K, rows, columns)."""
    right, below = np.zeros_like(ends), np.zeros_like(ends)
    right[:, :-1], below[:-1] = along_x, along_y
    diagonal = ends + right + below
    diagonal[:, 1:] += right[:, :-1]
    diagonal[1:] += below[:-1]
    return solve_grid(diagonal, (-right,), (-below,), wanted)
