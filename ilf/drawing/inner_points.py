"""Where a block's name or number is written: well inside it."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_LARGEST_SIDE = 480
"""Pixels that are looked at along the frame's longer side: names need no better place."""

InnerPoint = tuple[float, float, float]
"""Image coordinates x, y of the middle of a large circle inside a block, and its radius."""


def inner_points(labels: NDArray[np.int32]) -> dict[int, InnerPoint]:
    """Block label -> inner point, for a label map, int32 (H, W); very small blocks are left out."""
    step = max(-(-max(labels.shape) // _LARGEST_SIDE), 1)
    few = np.pad(np.ascontiguousarray(labels[step // 2 :: step, step // 2 :: step]), 1, constant_values=-1)
    inside = np.ones(few.shape, np.uint8)
    across, down = few[:, 1:] != few[:, :-1], few[1:] != few[:-1]
    inside[:, 1:][across] = 0
    inside[1:][down] = 0
    inside[few <= 0] = 0
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, 3).ravel()
    order = np.flatnonzero(distance)
    order = order[np.argsort(distance[order], kind="stable")]
    best = np.zeros(max(int(few.max()), 0) + 1, np.intp)
    best[few.ravel()[order]] = order  # the last, and so the farthest from the border, stays
    points = {}
    for label in np.flatnonzero(best):
        row, column = divmod(int(best[label]), few.shape[1])
        x, y = (column - 1) * step + step // 2 + 0.5, (row - 1) * step + step // 2 + 0.5
        points[int(label)] = x, y, float(distance[best[label]]) * step
    return points
