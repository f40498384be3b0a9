"""Pixels, missing depth and errors of the blocks of a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box, whole


@dataclass(frozen=True)
class BlockCounts:
    """Pixels of a block; `known` counts those with known depth or outside the depth camera's view."""

    pixels: int
    known: int

    @property
    def defect_rate(self) -> float:
        """Share of pixels without raw depth in the depth camera's view, 0-1."""
        return 1.0 - self.known / self.pixels if self.pixels else 0.0


class BlockTally:
    """Counts of all blocks of a label map, int32 (H, W), given a mask of pixels that lack no depth, bool (H, W)."""

    def __init__(self, labels: NDArray[np.int32], known: NDArray[np.bool_]) -> None:
        self._labels = labels
        self._known = known
        self._counts = np.zeros((2, 1), np.int64)
        self.add(whole(labels.shape))

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels; 0 is no block."""
        pixels, known = self._counts
        present = np.flatnonzero(pixels)
        return {int(label): BlockCounts(int(pixels[label]), int(known[label])) for label in present if label > 0}

    def add(self, box: Box, sign: int = 1) -> None:
        """Add the pixels of a box to the counts; with sign -1, subtract them."""
        here = self._labels[box]
        beyond = int(here.max()) + 1 - self._counts.shape[1]
        if beyond > 0:
            self._counts = np.pad(self._counts, ((0, 0), (0, beyond)))
        size = self._counts.shape[1]
        self._counts[0] += sign * np.bincount(here.ravel(), minlength=size)
        self._counts[1] += sign * np.bincount(here[self._known[box]], minlength=size)


# Errors of blocks.

GROUND_TRUTH, HOLD_OUT, EXPECTED = "ground truth", "hold-out depth", "expected error"


@dataclass(frozen=True)
class BlockErrors:
    """Errors of the current results: against ground truth, on hold-out depth with the current parameters, or expected.

    Attributes
    ----------
    source : str
        `GROUND_TRUTH`, `HOLD_OUT` or `EXPECTED`; "" where no error is known.
    rmse : mapping of int to float
        Block label -> root mean square error [m]; blocks without a known error are left out.
    """

    source: str = ""
    rmse: Mapping[int, float] = field(default_factory=dict)

    @staticmethod
    def expected(error: NDArray[np.float32], labels: NDArray[np.int32]) -> BlockErrors:
        """Return the root mean square of the expected error [m], float32 (H, W), NaN = unknown, over each block."""
        known = np.isfinite(error)
        inside = labels[known]
        counts = np.bincount(inside)
        sums = np.bincount(inside, np.square(error[known], dtype=np.float64))
        there = [int(label) for label in np.flatnonzero(counts) if label]
        return BlockErrors(EXPECTED, {label: float(np.sqrt(sums[label] / counts[label])) for label in there})
