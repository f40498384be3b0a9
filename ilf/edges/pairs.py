"""What holds between neighbouring pixels: between each one and its right neighbour, and its lower one."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Pairs = tuple[NDArray[np.bool_], NDArray[np.bool_]]
"""Right neighbours, shape (H, W - 1), and lower ones, shape (H - 1, W)."""


def sides(values: NDArray[Any]) -> tuple[tuple[NDArray[Any], NDArray[Any]], tuple[NDArray[Any], NDArray[Any]]]:
    """Both pixels of every pair: (left, right) and (upper, lower) of values of shape (H, W)."""
    return (values[:, :-1], values[:, 1:]), (values[:-1], values[1:])


def both(mask: NDArray[np.bool_]) -> Pairs:
    """Neighbours that both are in a mask of shape (H, W)."""
    right, below = (one & other for one, other in sides(mask))
    return right, below


def apart(labels: NDArray[np.int32]) -> Pairs:
    """Neighbours of different labels in a map of shape (H, W)."""
    right, below = (one != other for one, other in sides(labels))
    return right, below


def mark(pairs: Pairs) -> NDArray[np.bool_]:
    """Pairs as a picture of shape (H, W), a line 1 px wide: the left or upper pixel of every pair is set."""
    right, below = pairs
    marked = np.zeros((right.shape[0], below.shape[1]), bool)
    marked[:, :-1] |= right
    marked[:-1] |= below
    return marked


def long_lines(pairs: Pairs, length: int) -> Pairs:
    """Those pairs whose 8-connected lines are longer than `length` pixels."""
    _, lines, sizes, _ = cv2.connectedComponentsWithStats(mark(pairs).astype(np.uint8), connectivity=8)
    long = sizes[:, cv2.CC_STAT_AREA][lines] > length
    return pairs[0] & long[:, :-1], pairs[1] & long[:-1]
