"""Thin gaps at jumps: what cameras leave missing along outlines, between two surfaces that are known.

There the filter draws a ramp from one surface to the other, and follows all wrong samples of the rims. A median of the
known depth around, weighted by distance and colour, is on one of the surfaces. The middle between ramp and median is
closer to exact depth than either, and to measured depth, whose outlines are off colour's by some pixels.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame

Array = NDArray[np.float32]

_WIDEST = 4
"""Maximum width of a thin gap [px]."""

_SURFACE = 3
"""It lies between surfaces: squares of this side [px] that are all known. Scattered samples are none: among them, depth
itself contains the jumps."""

_REACH = 3
_AROUND = np.argwhere(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, [2 * _REACH + 1] * 2)) - _REACH
"""Rows and columns of the pixels around one, which is in their middle."""

_JUMP = 1.05
"""Minimum ratio of two depths around between which there is none: slopes have smaller steps."""

_DISTANCE, _COLOUR = 1.5, 20.0
"""Distance [px] and difference of colour (8-bit Lab) at which a known pixel has 61 % of its weight."""

_AT_A_TIME = 1 << 16
"""Maximum number of pixels processed at a time."""


@once_per_frame
def median_in_thin_gaps(frame: RGBDFrame) -> Array:
    """Weighted median of the known depth around [m], in thin gaps at jumps; float32 (H, W), NaN elsewhere.

    Examples
    --------
    >>> depth = np.full((20, 30), 1.0)
    >>> depth[:, 15:] = 2.0
    >>> depth[:, 14:17] = np.nan
    >>> colour = np.zeros((20, 30, 3), np.uint8)
    >>> colour[:, 16:] = 255
    >>> median_in_thin_gaps(RGBDFrame(colour, depth))[10, 13:18].tolist()
    [nan, 1.0, 1.0, 2.0, nan]
    """
    found = np.full(frame.shape, np.nan, np.float32)
    rows, columns = np.nonzero(_thin_gaps(frame.known))
    for first in range(0, rows.size, _AT_A_TIME):
        part = slice(first, first + _AT_A_TIME)
        at = np.stack([rows[part], columns[part]])
        depth = _values_around(frame.depth, at)
        jumps = _jumps(depth)
        if jumps.any():
            at, depth = np.compress(jumps, at, axis=1), np.compress(jumps, depth, axis=1)
            found[tuple(at)] = _weighted_median(depth, _weights(frame.edge_rgb, at))
    return found


def _thin_gaps(known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Missing pixels of gaps of up to `_WIDEST` pixels between surfaces; around each is a pixel of one."""
    square, gap = (np.ones((side, side), np.uint8) for side in (_SURFACE, _WIDEST + 1))
    surfaces = cv2.morphologyEx(known.view(np.uint8), cv2.MORPH_OPEN, square)
    return (cv2.morphologyEx(surfaces, cv2.MORPH_CLOSE, gap) > 0) & ~known


def _values_around(image: NDArray[Any], at: NDArray[np.intp]) -> NDArray[Any]:
    """Values of the pixels around N pixels, (len(_AROUND), N, ...); beyond the frame, those at its border."""
    padded = np.asarray(cv2.copyMakeBorder(image, _REACH, _REACH, _REACH, _REACH, cv2.BORDER_REPLICATE))
    row = padded.shape[1], 1
    places = ((_AROUND + _REACH) @ row)[:, np.newaxis] + row @ at
    return padded.reshape(-1, *image.shape[2:])[places]


def _jumps(around: Array) -> NDArray[np.bool_]:
    """Whether the known depth around pixels jumps."""
    ordered = np.sort(around, axis=0)  # NaN last
    return np.asarray((ordered[1:] > np.float32(_JUMP) * ordered[:-1]).any(axis=0))


def _weights(colour: NDArray[Any], at: NDArray[np.intp]) -> Array:
    """Weights of the pixels around some pixels."""
    lab = cv2.cvtColor(_values_around(colour, at), cv2.COLOR_RGB2LAB).astype(np.float32)
    away = np.square(_AROUND).sum(axis=1)[:, np.newaxis] / _DISTANCE**2
    unlike = lab - lab[len(lab) // 2]
    squares = np.einsum("knc, knc -> kn", unlike, unlike)
    return np.exp(-(squares / _COLOUR**2 + away) / 2).astype(np.float32)


def _weighted_median(values: Array, weights: Array) -> Array:
    """Weighted medians along the first axis, without NaN."""
    order = np.argsort(values, axis=0, kind="stable")
    ordered = np.take_along_axis(values, order, axis=0)
    sums = np.take_along_axis(np.where(np.isnan(values), np.float32(0), weights), order, axis=0).cumsum(axis=0)
    middle = np.argmax(2 * sums >= sums[-1], axis=0)
    return np.asarray(np.take_along_axis(ordered, middle[np.newaxis], axis=0)[0], np.float32)
