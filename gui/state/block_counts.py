"""Pixels and missing depth of blocks, counted box by box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box, whole


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

    def add(self, box: Box) -> None:
        """Add the pixels of a box to the counts."""
        self._count(box, 1)

    def take_out(self, box: Box) -> None:
        """Subtract the pixels of a box from the counts."""
        self._count(box, -1)

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels; 0 is no block."""
        pixels, known = self._counts
        present = np.flatnonzero(pixels)
        return {int(label): BlockCounts(int(pixels[label]), int(known[label])) for label in present if label > 0}

    def _count(self, box: Box, sign: int) -> None:
        here = self._labels[box]
        beyond = int(here.max()) + 1 - self._counts.shape[1]
        if beyond > 0:
            self._counts = np.pad(self._counts, ((0, 0), (0, beyond)))
        size = self._counts.shape[1]
        self._counts[0] += sign * np.bincount(here.ravel(), minlength=size)
        self._counts[1] += sign * np.bincount(here[self._known[box]], minlength=size)
