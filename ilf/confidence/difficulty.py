"""How much harder a frame is than it looks: part of its own depth is hidden from a small copy of it, and completed."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..completion import complete
from ..errors import InputError
from ..frame import RGBDFrame
from ..parameters import preset
from ..per_frame import once_per_frame
from .features import FLOOR, error_features, filled_pixels, usual_edges
from .model import WITHIN, ErrorModel

_HALVED = 2
"""One pixel of so many in a row, and in a column, makes the small copy; of more in a frame so large that the copy's
longer side would be above `_LONGEST`."""

_LONGEST = 960
"""[px], so that the test takes no longer in larger frames."""

_RADIUS, _APART = 0.06, 0.22
"""Radius of the discs that are hidden, and how far apart their middles are, in widths of the frame."""

_FEWEST = 500
"""With fewer hidden pixels than that, nothing can be said."""


def frame_difficulty(frame: RGBDFrame, model: ErrorModel) -> float | None:
    """What the logarithms of errors are above those that a model expects of a frame of usual difficulty, so that 68 %
    of the hidden pixels would lie within it; None if too little depth is known to tell."""
    test = own_test(frame)
    return None if test is None else difficulty_of(*test, model)


def difficulty_of(features: NDArray[np.floating], logarithms: NDArray[np.floating], model: ErrorModel) -> float:
    """`frame_difficulty` by what `own_test` gives."""
    return float(np.quantile(logarithms - model.logarithms(features), WITHIN))


@once_per_frame
def own_test(frame: RGBDFrame) -> tuple[NDArray[np.float32], NDArray[np.float64]] | None:
    """Features (N, 13) and logarithms (N,) of |error| / completed depth at the hidden pixels, worked out once.

    None if too little depth is known. What the frame's own blocks are has no part in it.
    """
    stride = max(_HALVED, -(-max(frame.shape) // _LONGEST))
    depth = np.ascontiguousarray(frame.depth[stride // 2 :: stride, stride // 2 :: stride])
    hidden = _discs(depth.shape) & np.isfinite(depth)
    if min(np.count_nonzero(hidden), np.count_nonzero(np.isfinite(depth) & ~hidden)) < _FEWEST:
        return None
    rgb = np.asarray(cv2.resize(frame.rgb, depth.shape[::-1], interpolation=cv2.INTER_AREA), np.uint8)
    try:
        small = RGBDFrame(rgb, np.where(hidden, np.float32(np.nan), depth))
    except InputError:  # what is left of a frame at the limits of depth may lie beyond them
        return None
    # however sparse the depth is, one block of all pixels is completed
    completed = complete(small, np.ones(small.shape, np.int32), preset(min_known_share=0), threads=1).depth
    filled = filled_pixels(small, completed)
    there = hidden[filled]
    found = completed[filled][there].astype(np.float64)
    shares = np.abs(found - depth[filled][there]) / found
    return error_features(small, completed, usual_edges(small))[there], np.log(np.maximum(shares, FLOOR))


def _discs(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Discs at the corners of triangles, about a quarter of all pixels."""
    rows, columns = np.indices(shape, np.float32)
    apart, height = _APART * shape[1], _APART * shape[1] * np.sqrt(0.75)
    row = np.round(rows / height)
    shifted = columns - apart * (row % 2) / 2
    column = np.round(shifted / apart)
    return np.hypot(rows - row * height, shifted - column * apart) <= _RADIUS * shape[1]
