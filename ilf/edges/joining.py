"""Edges of the filter from depth edges and contours together: each knows what the other does not."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

_BESIDE, _SHARP = 3, 4
"""Within so many pixels the crest of a line stands out, and how sharply."""

_GAIN = 1.4
"""Strength of a crest in its probability."""

_NEAR, _POSSIBLE = 2, 0.5
"""A contour counts in full if a jump within so many pixels has at least this probability."""


def joined(jump: Array, contours: Array | None = None) -> Array:
    """Strength of edges: the crests of what a jump is taken for, and contours as far as one is possible there.

    A network of depth edges knows where depth jumps, but is seldom sure to the pixel; contours are sharp and leave
    little out, but part what is on one surface. A gap in an edge costs more than an edge too many.

    Parameters
    ----------
    jump : ndarray of float32, shape (H, W)
        Probability of a depth jump.
    contours : ndarray of float32, shape (H, W), optional
        Strength of contours in [0, 1].

    Returns
    -------
    ndarray of float32, shape (H, W)
        In [0, 1].
    """
    crest = _GAIN * jump * (jump / np.maximum(_largest_within(jump, _BESIDE), np.float32(1e-4))) ** _SHARP
    if contours is None:
        return np.minimum(crest, 1).astype(np.float32)
    possible = np.sqrt(np.minimum(_largest_within(jump, _NEAR) / np.float32(_POSSIBLE), 1))
    return np.minimum(np.maximum(crest, possible * contours), 1).astype(np.float32)


def _largest_within(values: Array, radius: int) -> Array:
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2)
    return np.asarray(cv2.dilate(values, disk), np.float32)
