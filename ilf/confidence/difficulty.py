"""How much harder a frame is than it looks: part of its own depth is hidden, and walks from there tell what it was.

What they say is no completion, but as far as frames differ in how hard they are, it is with one as with the other.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame
from ..per_frame import once_per_frame
from .features import FLOOR, features_at, usual_contours
from .model import WITHIN, ErrorModel
from .walks import walk

_LONGEST = 640
"""[px], so that the test takes no longer in larger frames: of those, one pixel of so many in a row, and in a column,
makes a smaller copy."""

_RADIUS, _APART = 0.06, 0.22
"""Radius of the discs that are hidden, and how far apart their middles are, in widths of the frame."""

_LOOKED_AT = 10_000
"""Of the hidden pixels so many are looked at, at most."""

_FEWEST = 2000
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
    stride = -(-max(frame.shape) // _LONGEST)
    depth = np.ascontiguousarray(frame.depth[stride // 2 :: stride, stride // 2 :: stride])
    if depth.size < 2 * _FEWEST:  # so thin that the copy has no column, perhaps
        return None
    hidden = _discs(depth.shape) & np.isfinite(depth)
    if min(np.count_nonzero(hidden), np.count_nonzero(np.isfinite(depth) & ~hidden)) < _FEWEST:
        return None
    left = np.where(hidden, np.float32(np.nan), depth)
    contours = cv2.resize(usual_contours(frame), depth.shape[::-1], interpolation=cv2.INTER_AREA)
    edges = np.asarray(contours, np.float32)
    walks = walk(left, edges)
    completed = np.exp(walks.depth)
    places = np.flatnonzero(hidden)
    places = places[:: -(-len(places) // _LOOKED_AT)]
    found = completed.ravel()[places].astype(np.float64)
    shares = np.abs(found - depth.ravel()[places]) / found
    return features_at(places, left, completed, edges, walks), np.log(np.maximum(shares, FLOOR))


def _discs(shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Discs at the corners of triangles, about a quarter of all pixels."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    apart, height = _APART * shape[1], _APART * shape[1] * np.sqrt(0.75)
    row = np.round(rows / height)
    shifted = (columns - apart * (row % 2) / 2).astype(np.float32)
    beside = shifted - np.float32(apart) * np.round(shifted / np.float32(apart))
    return np.asarray(beside**2 + ((rows - row * height) ** 2).astype(np.float32) <= (_RADIUS * shape[1]) ** 2)
