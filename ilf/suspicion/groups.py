"""Pixels that belong together make a place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects
from skimage.measure import label as connected_regions

from ..blocks import Box

_GAP = 3
"""Pixels of one block not farther apart than twice this [px] belong together."""

_LARGEST = 60
"""Of one kind, no more than so many places are of interest."""


@dataclass(frozen=True, eq=False)
class Group:
    """Pixels of one block that belong together.

    Attributes
    ----------
    label : int
        The block.
    box : tuple of slice
        Rows and columns that they take up.
    rows, columns : ndarray of int64, shape (n,)
        The pixels.
    harm : float
        What they may do, as in `Place.score`.
    """

    label: int
    box: Box
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    harm: float

    @property
    def point(self) -> tuple[float, float]:
        """The pixel that lies nearest to the middle of all, (x, y) of its centre."""
        away = np.abs(self.rows - np.median(self.rows)) + np.abs(self.columns - np.median(self.columns))
        nearest = int(np.argmin(away))
        return float(self.columns[nearest]) + 0.5, float(self.rows[nearest]) + 0.5


def number_groups(pixels: NDArray[np.bool_], labels: NDArray[np.int32]) -> NDArray[np.int32]:
    """Groups 1, 2, ... of pixels of a mask that lie close to each other in one block; 0 elsewhere, int32 (H, W)."""
    square = np.ones((2 * _GAP + 1,) * 2, np.uint8)
    wide = cv2.dilate(pixels.astype(np.uint8), square) > 0
    found = connected_regions(np.where(wide, labels, 0), background=0, connectivity=2)
    return np.where(pixels, found, 0).astype(np.int32)


def largest_groups(numbers: NDArray[np.int32], harm: NDArray[Any], labels: NDArray[np.integer]) -> Iterator[Group]:
    """The groups that may do most harm.

    Parameters
    ----------
    numbers : ndarray of int32, shape (H, W)
        Groups 1, 2, ..., 0 elsewhere.
    harm : ndarray of float, shape (groups + 1,)
        Harm of each.
    labels : ndarray of int, shape (H, W)
        The block of every pixel of a group.
    """
    boxes = find_objects(numbers)
    for number in np.argsort(-harm[1:], kind="stable")[:_LARGEST].tolist():
        box = boxes[number]
        if box is None or harm[number + 1] <= 0:
            continue
        rows, columns = np.nonzero(numbers[box] == number + 1)
        rows, columns = rows + box[0].start, columns + box[1].start
        yield Group(int(labels[rows[0], columns[0]]), box, rows, columns, float(harm[number + 1]))
