"""What the known depth says of surfaces: where it jumps, where it bends, and where it cannot say anything."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ..._runtime.cancellation import check_stopped
from ...data.pixel_grids import Pairs, both, long_lines, mark, sides

TRUSTED_DISTANCE = 3.0
"""How far [px] from known depth a jump is still one: farther inside a hole, it is only where two nearest fills meet."""

JUMP_LENGTH = 10
"""Jumps part surfaces in lines longer than this [px]; shorter ones are flying pixels and noise."""

_REACH, _AVERAGED = 6, 9
"""Over how many pixels to either side a surface must go on to count as smooth, and the side of the squares over which
its depth is averaged before."""

_SEEN = _REACH + _AVERAGED // 2
"""How far [px] what is averaged reaches."""

_BEND_SHARE, _BEND_PER_METRE = 0.01, 0.003
"""Largest departure from a straight line over `_REACH` on a smooth surface, as a share of the depth: the larger of a
constant, which a right-angled corner of a room in a Kinect's picture exceeds by about half, and one that grows with
depth as the noise of such sensors does."""


@dataclass(frozen=True, eq=False)
class Relief:
    """Evidence in the known depth, for every pixel or pair of neighbours.

    Attributes
    ----------
    near : ndarray of bool, shape (H, W)
        Pixels within `TRUSTED_DISTANCE` of known depth: where a jump would have been seen.
    all_jumps : pair of ndarray of bool
        Neighbours between which depth jumps.
    jumps : pair of ndarray of bool
        Those in lines of more than `JUMP_LENGTH`.
    judged : ndarray of bool, shape (H, W)
        Pixels around which there is depth enough, and no jump, to say whether the surface bends.
    bend : ndarray of float32, shape (H, W)
        Departure from a plane where it is judged, in multiples of what a smooth surface shows; 0 elsewhere.
    """

    near: NDArray[np.bool_]
    all_jumps: Pairs
    jumps: Pairs
    judged: NDArray[np.bool_]
    bend: NDArray[np.float32]

    @property
    def edges(self) -> NDArray[np.bool_]:
        """Jumps of any length as lines 1 px wide, bool (H, W)."""
        return mark(self.all_jumps)


def find_relief(depth: NDArray[np.float32], jump: float, share: float) -> Relief:
    """Jumps and bends of the known depth.

    Neighbours of the filled depth (`filled_depth`) that differ by more than max(jump, share * depth) are a jump if
    both lie within 3 px of known depth; so jumps are seen across gaps of up to 6 px, and no farther.

    A surface bends where the inverse depth, which is linear on a plane, averaged over 9 x 9 pixels, departs from a
    straight line over 6 px to either side, along the row or along the column. That is judged where there is neither a
    jump nor a larger hole in the 21 x 21 pixels around.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    jump : float
        Smallest jump [m].
    share : float
        Smallest jump as a share of the nearer depth.
    """
    if np.isnan(depth).all():
        nowhere = np.zeros(depth.shape, bool)
        return Relief(nowhere, both(nowhere), both(nowhere), nowhere, np.zeros(depth.shape, np.float32))
    filled, distance = filled_depth(depth)
    check_stopped()
    near = distance <= TRUSTED_DISTANCE
    right, below = (
        (np.abs(one - other) > np.maximum(jump, share * np.minimum(one, other))) & trusted
        for (one, other), trusted in zip(sides(filled), both(near), strict=True)
    )
    judged = _whole(near & ~mark((right, below)))
    bend = np.where(judged, _bend(filled), np.float32(0))
    return Relief(near, (right, below), long_lines((right, below), JUMP_LENGTH), judged, bend)


def filled_depth(depth: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Depth to look for jumps in: gaps filled from the nearest known pixel, outliers taken out by a 5 x 5 median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.

    Returns
    -------
    filled : ndarray of float32, shape (H, W)
        Depth [m] everywhere.
    distance : ndarray of float64, shape (H, W)
        To the nearest known pixel [px].
    """
    distance, (rows, columns) = distance_transform_edt(np.isnan(depth), return_indices=True)
    return np.asarray(cv2.medianBlur(np.ascontiguousarray(depth[rows, columns]), 5), np.float32), distance


def _whole(surface: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels around which there is nothing but surface, as far as the image goes."""
    square = np.ones((2 * _SEEN + 1,) * 2, np.uint8)
    return cv2.erode(surface.astype(np.uint8), square, borderType=cv2.BORDER_CONSTANT, borderValue=1) > 0


def _bend(filled: NDArray[np.float32]) -> NDArray[np.float32]:
    # beyond the image, planes go on
    beyond = np.pad(1 / filled, _SEEN, mode="reflect", reflect_type="odd")
    rim = _SEEN - _REACH
    inverse = cv2.blur(beyond, (_AVERAGED, _AVERAGED))[rim:-rim, rim:-rim]
    centre, before, after = slice(_REACH, -_REACH), slice(None, -2 * _REACH), slice(2 * _REACH, None)
    twice = 2 * inverse[centre, centre]
    along_column = inverse[before, centre] - twice + inverse[after, centre]
    along_row = inverse[centre, before] - twice + inverse[centre, after]
    bend = filled * np.maximum(np.abs(along_column), np.abs(along_row))
    return np.asarray(bend / np.maximum(_BEND_SHARE, _BEND_PER_METRE * filled), np.float32)
