"""Jumps and bends of the known depth."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.cancellation import check_cancelled
from ...data.pixel_grids import Pairs, both, filled_from_nearest, long_lines, mark, sides, strips

MAX_JUMP_DISTANCE = 3.0
"""Maximum distance [px] of a jump from known depth: farther inside a hole, a jump is an artefact of nearest-pixel
filling."""

JUMP_LENGTH = 10
"""Jumps separate surfaces in lines longer than this [px]; shorter ones are flying pixels and noise."""

_CONTINUITY_DISTANCE, _AVERAGED = 6, 9
"""Distance [px] to either side over which a surface must be continuous to count as smooth, and the side [px] of the
squares over which its depth is averaged first."""

_BEND_RADIUS = _CONTINUITY_DISTANCE + _AVERAGED // 2
"""Radius [px] of all depth that is used for a pixel's bend."""

_BEND_SHARE, _BEND_PER_METRE = 0.01, 0.003
"""Maximum deviation from a straight line over `_CONTINUITY_DISTANCE` on a smooth surface, as a fraction of the depth:
the larger of a constant, which a right-angled room corner in a Kinect's image exceeds by about half, and a term that
grows with depth like the noise of such sensors."""


@dataclass(frozen=True, eq=False)
class Relief:
    """Jumps and bends of the known depth, for every pixel or pair of neighbours.

    Attributes
    ----------
    near : ndarray of bool, shape (H, W)
        Pixels within `MAX_JUMP_DISTANCE` of known depth, where a jump would have been detected.
    all_jumps : pair of ndarray of bool
        Neighbours with a depth jump between them.
    jumps : pair of ndarray of bool
        Jumps in lines of more than `JUMP_LENGTH`.
    evaluated : ndarray of bool, shape (H, W)
        Pixels with a valid bend: with enough depth around them, and no jump.
    bend : ndarray of float32, shape (H, W)
        Deviation from a plane where `evaluated`, in multiples of the maximum for a smooth surface; 0 elsewhere.
    filled : ndarray of float32, shape (H, W)
        The depth in which they were found (`filled_depth`) [m]; NaN if none is known at all.
    """

    near: NDArray[np.bool_]
    all_jumps: Pairs
    jumps: Pairs
    evaluated: NDArray[np.bool_]
    bend: NDArray[np.float32]
    filled: NDArray[np.float32]

    @property
    def edges(self) -> NDArray[np.bool_]:
        """Jumps of any length as lines 1 px wide, bool (H, W)."""
        return mark(self.all_jumps)


def find_relief(depth: NDArray[np.float32], jump: float, share: float) -> Relief:
    """Find jumps and bends of the known depth.

    Neighbours of the filled depth (`filled_depth`) that differ by more than max(jump, share * depth) are a jump if
    both lie within 3 px of known depth; so jumps are detected across gaps of up to 6 px.

    A surface bends where the inverse depth, which is linear on a plane, averaged over 9 x 9 pixels, deviates from a
    straight line over 6 px to either side, along the row or along the column. The bend is valid where there is neither
    a jump nor a larger hole in the 21 x 21 pixels around.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    jump : float
        Smallest jump [m].
    share : float
        Smallest jump as a fraction of the nearer depth.
    """
    if np.isnan(depth).all():
        nowhere = np.zeros(depth.shape, bool)
        return Relief(nowhere, both(nowhere), both(nowhere), nowhere, np.zeros(depth.shape, np.float32), depth)
    filled = filled_depth(depth)
    check_cancelled()
    near = cv2.distanceTransform(np.isnan(depth).view(np.uint8), cv2.DIST_L2, 5) <= MAX_JUMP_DISTANCE
    jumps = both(near)
    for rows, *_ in strips(len(depth)):
        for (one, other), trusted in zip(sides(filled[rows.start : rows.stop + 1]), jumps, strict=True):
            here = trusted[rows]
            one, other = one[: len(here)], other[: len(here)]
            here &= np.abs(one - other) > np.maximum(jump, share * np.minimum(one, other))
    # pixels whose whole neighbourhood inside the image is surface
    square = np.ones((2 * _BEND_RADIUS + 1,) * 2, np.uint8)
    surface = (near & ~mark(jumps)).view(np.uint8)
    evaluated = cv2.erode(surface, square, borderType=cv2.BORDER_CONSTANT, borderValue=1) > 0
    return Relief(near, jumps, long_lines(jumps, JUMP_LENGTH), evaluated, _bend(filled, evaluated), filled)


def filled_depth(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth for finding jumps: gaps filled from the nearest known pixel, outliers removed by a 5 x 5 median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] everywhere.
    """
    return np.asarray(cv2.medianBlur(filled_from_nearest(depth), 5), np.float32)


def _bend(filled: NDArray[np.float32], evaluated: NDArray[np.bool_]) -> NDArray[np.float32]:
    # planes continue beyond the image
    beyond = np.pad(1 / filled, _BEND_RADIUS, mode="reflect", reflect_type="odd")
    rim = _BEND_RADIUS - _CONTINUITY_DISTANCE
    inverse = np.asarray(cv2.blur(beyond, (_AVERAGED, _AVERAGED))[rim:-rim, rim:-rim], np.float32)
    bend = np.empty_like(filled)
    for rows, *_ in strips(len(filled)):
        relative = _deviation(inverse[rows.start : rows.stop + 2 * _CONTINUITY_DISTANCE]) * filled[rows]
        relative /= np.maximum(_BEND_SHARE, _BEND_PER_METRE * filled[rows])
        bend[rows] = np.where(evaluated[rows], relative, np.float32(0))
    return bend


def _deviation(inverse: NDArray[np.float32]) -> NDArray[np.float32]:
    """Larger deviation from a straight line along the column or the row, without `_CONTINUITY_DISTANCE` on every
    side."""
    by = _CONTINUITY_DISTANCE
    centre, before, after = slice(by, -by), slice(None, -2 * by), slice(2 * by, None)
    twice = 2 * inverse[centre, centre]
    along_column = inverse[before, centre] - twice + inverse[after, centre]
    along_row = inverse[centre, before] - twice + inverse[centre, after]
    return np.maximum(np.abs(along_column), np.abs(along_row))
