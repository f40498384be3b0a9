"""A block's own word: around wide gaps, edges fade towards the block's own known depth alone.

Among dense samples the depth itself says where the jumps are, so edges fade towards known depth. But beside a wide gap,
what is known of other blocks says nothing of this one: there it is the edge that must part them.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
Mask = NDArray[np.bool_]

WIDE = 8
"""A gap is wide where a pixel is so far [px] from known depth; up to there, samples on both sides say enough."""


def around_wide_gaps(distance: Array) -> Mask:
    """Pixels of wide gaps and beside them, bool (H, W), from every pixel's distance to known depth."""
    square = np.ones((2 * WIDE + 1,) * 2, np.uint8)
    return cv2.dilate((distance >= WIDE).astype(np.uint8), square) > 0


def own_distance(distance: Array, inside: Mask) -> Array:
    """How far [px] pixels are from the known depth that edges fade towards: in the block and around wide gaps, its own.

    Parameters
    ----------
    distance : ndarray of float32, shape (H, W)
        To any known depth, 0 there.
    inside : ndarray of bool, shape (H, W)
        The block's pixels.
    """
    if not (distance >= WIDE).any():
        return distance
    own = cv2.distanceTransform((~(inside & (distance == 0))).astype(np.uint8), cv2.DIST_L2, 5)
    return np.where(inside & around_wide_gaps(distance), own, distance).astype(np.float32)
