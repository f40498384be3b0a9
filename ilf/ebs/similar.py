"""A stroke kept to what is like its start: of like colour and depth, and not beyond a strong edge."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame
from ..per_frame import once_per_image
from .edit import Stroke
from .usual_relief import usual_relief

_EDGE = 0.5
"""Edge strength from which on an edge is strong."""

_COLOUR = (40, 16, 16)
"""How far a colour may be off that at the start, in 8-bit Lab: more in lightness, which shading changes."""

_DEPTH_SHARE = 0.15
"""How far depth may be off that at the start, as a share of it."""

_INTO_EDGE = 3
"""How far [px] into the width of an edge a stroke may go on, as long as colour and depth are alike."""

_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)


class Similar:
    """What a stroke may sweep that begins at a point.

    Parameters
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    x, y : float
        Where the stroke begins, in image coordinates; off the frame, everything is similar.
    """

    def __init__(self, frame: RGBDFrame, strength: NDArray[np.float32], x: float, y: float) -> None:
        self._mask = np.ones(frame.shape, bool)
        row, column = int(np.floor(y)), int(np.floor(x))
        if 0 <= row < frame.shape[0] and 0 <= column < frame.shape[1]:
            self._mask = _reached(_like(frame, row, column), strength < _EDGE, usual_relief(frame).edges, row, column)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """All that is similar, bool (H, W)."""
        return self._mask

    def limit(self, stroke: Stroke) -> Stroke | None:
        """The part of a stroke that is similar; None if there is none."""
        kept = stroke.mask & self._mask[stroke.box]
        return Stroke(stroke.box, kept) if kept.any() else None


def _like(frame: RGBDFrame, row: int, column: int) -> NDArray[np.bool_]:
    """Pixels of about the colour and depth at a pixel; where depth is missing, colour decides."""
    around = slice(max(row - 1, 0), row + 2), slice(max(column - 1, 0), column + 2)
    lab = _lab(frame.rgb)
    start = np.median(lab[around].reshape(-1, 3), axis=0)
    like = _within(lab, start - _COLOUR, start + _COLOUR)
    near = frame.depth[around]
    if np.isfinite(near).any():
        depth = float(np.nanmedian(near))
        low, high = (np.array(depth * (1 + sign * _DEPTH_SHARE)) for sign in (-1, 1))
        like &= _within(frame.depth, low, high) | ~frame.known
    like[row, column] = True
    return like


def _within(values: NDArray[Any], low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.bool_]:
    return cv2.inRange(values, low, high) > 0


@once_per_image
def _lab(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(cv2.GaussianBlur(rgb, (0, 0), 1.0), cv2.COLOR_RGB2Lab), np.uint8)


def _reached(
    like: NDArray[np.bool_], weak: NDArray[np.bool_], jumps: NDArray[np.bool_], row: int, column: int
) -> NDArray[np.bool_]:
    """What can be reached from a pixel over what is like it, and a little way into the edges around."""
    open_ground = (like & weak & ~jumps).astype(np.uint8)
    open_ground[row, column] = 1
    cv2.floodFill(open_ground, None, (column, row), 2, flags=4)
    reached, edge = open_ground == 2, like & ~(weak & ~jumps)
    last = reached
    for _ in range(_INTO_EDGE):
        last = (cv2.dilate(last.astype(np.uint8), _CROSS) > 0) & edge & ~reached
        reached = reached | last
        # a jump lies behind the pixel that is marked: that one may be swept, those behind it not
        last = last & ~jumps
    return reached
