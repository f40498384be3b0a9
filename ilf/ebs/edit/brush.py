"""The brush: which pixels a stroke of it sweeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...blocks import Box
from .patches import Mask, Points


@dataclass(frozen=True, eq=False)
class Stroke:
    """Pixels that a brush has swept: a box of the frame and a mask inside it."""

    box: Box
    mask: Mask


def brush_stroke(shape: tuple[int, int], points: Points, radius: float) -> Stroke | None:
    """Pixels whose centre lies within `radius` [px] of the line through `points`; None if all are off the frame.

    The pixel under each end of a segment always belongs to it, so a tiny brush still paints.
    """
    path = np.asarray(points, np.float64)
    reach = radius + 1
    top, left = np.floor(path[:, ::-1].min(axis=0) - reach).astype(int)
    bottom, right = np.ceil(path[:, ::-1].max(axis=0) + reach).astype(int)
    top, left = max(top, 0), max(left, 0)
    bottom, right = min(bottom, shape[0]), min(right, shape[1])
    if top >= bottom or left >= right:
        return None
    centre_y, centre_x = np.mgrid[top:bottom, left:right] + 0.5
    mask = np.zeros(centre_x.shape, bool)
    for start, end in zip(path, path[1:] if len(path) > 1 else path, strict=False):
        mask |= _near_segment(centre_x, centre_y, start, end, radius)
    for x, y in path:
        row, column = int(np.floor(y)) - top, int(np.floor(x)) - left
        if 0 <= row < mask.shape[0] and 0 <= column < mask.shape[1]:
            mask[row, column] = True
    if not mask.any():
        return None
    return Stroke((slice(int(top), int(bottom)), slice(int(left), int(right))), mask)


def _near_segment(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    radius: float,
) -> NDArray[np.bool_]:
    along = end - start
    length = float(along @ along)
    share = 0.0 if length == 0 else np.clip(((x - start[0]) * along[0] + (y - start[1]) * along[1]) / length, 0, 1)
    off_x, off_y = x - start[0] - share * along[0], y - start[1] - share * along[1]
    return off_x**2 + off_y**2 <= radius**2
