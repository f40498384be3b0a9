"""Morphology on inverted depth."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame

_DIAMOND = np.array([[0, 0, 1, 0, 0], [0, 1, 1, 1, 0], [1, 1, 1, 1, 1], [0, 1, 1, 1, 0], [0, 0, 1, 0, 0]], np.uint8)
_CLOSING, _SMALL_HOLES, _LARGE_HOLES = (np.ones((side, side), np.uint8) for side in (5, 7, 31))
_BLUR = (5, 5)
_TINY = np.finfo(np.float32).tiny


def morphology(frame: RGBDFrame) -> NDArray[np.float32]:
    """The steps of Ku, Harakeh and Waslander, "In defense of classical image processing", 2018 (IP-Basic).

    Depth is inverted so that dilation lets the near win; then a dilation by a diamond, a closing, small holes, large
    holes, a median and a Gaussian blur. Holes wider than the largest element stay missing.
    """
    # any depth beyond the farthest will do, as long as no known pixel is 0, which stands for empty
    beyond = np.float32(np.nanmax(frame.depth) + 1.0)
    inverted = np.where(frame.known, beyond - frame.depth, np.float32(0.0))
    inverted = cv2.dilate(inverted, _DIAMOND)
    inverted = cv2.morphologyEx(inverted, cv2.MORPH_CLOSE, _CLOSING)
    for element in (_SMALL_HOLES, _LARGE_HOLES):
        inverted = np.where(inverted > 0, inverted, cv2.dilate(inverted, element))
    inverted = np.where(inverted > 0, cv2.medianBlur(inverted, 5), inverted)
    # empty pixels take no part in the blur
    filled = (inverted > 0).astype(np.float32)
    blurred = cv2.GaussianBlur(inverted, _BLUR, 0) / np.maximum(cv2.GaussianBlur(filled, _BLUR, 0), _TINY)
    return np.where(filled > 0, beyond - blurred, np.float32(np.nan))
