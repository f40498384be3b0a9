"""Colour maps: lookup tables from 8-bit indices to colours. Index 0, missing, is grey in all of them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]
"""Red, green, blue, 0-255."""

MISSING: Colour = (178, 182, 189)

DEPTH_MAP = "viridis"
"""Colour map of depth, as in the window: its steps look equal, and colour-blind people can read it."""

_BELOW, _ZERO, _ABOVE = (33, 84, 176), (246, 246, 244), (186, 32, 42)


def depth_colours() -> NDArray[np.uint8]:
    """Colour map of depth, uint8 (256, 3): near is dark."""
    return _of_map(cv2.COLORMAP_VIRIDIS)


def error_colours() -> NDArray[np.uint8]:
    """Colour map of absolute errors, uint8 (256, 3): inferno, small is dark."""
    return _of_map(cv2.COLORMAP_INFERNO)


def difference_colours() -> NDArray[np.uint8]:
    """Colour map of signed differences, uint8 (256, 3): blue below zero, nearly white at zero, red above."""
    below, zero, above = (np.array(colour, np.float64) for colour in (_BELOW, _ZERO, _ABOVE))
    t = np.linspace(-1, 1, 255)[:, None]
    return _with_missing(np.round(zero + np.abs(t) ** 0.8 * (np.where(t < 0, below, above) - zero)))


def _of_map(number: int) -> NDArray[np.uint8]:
    column = np.round(np.linspace(0, 255, 255)).astype(np.uint8)[:, None]
    return _with_missing(cv2.applyColorMap(column, number)[:, 0, ::-1])


def _with_missing(colours: NDArray[np.number]) -> NDArray[np.uint8]:
    return np.vstack([MISSING, colours]).astype(np.uint8)
