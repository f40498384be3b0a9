"""Pieces of blocks: what a click can give to another block."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def piece_at(
    labels: NDArray[np.int32], x: float, y: float, regions: NDArray[np.int32] | None = None
) -> NDArray[np.bool_]:
    """The piece of a block that lies under a point.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    x, y : float
        The point in image coordinates.
    regions : ndarray of int32, shape (H, W), optional
        Regions of the extraction (`Extraction.contracted`). With them, the piece ends where the region under the point
        does, unless there is none.

    Returns
    -------
    ndarray of bool, shape (H, W)
        4-connected pixels of the same label, which may be 0; empty if the point is off the frame.
    """
    piece = np.zeros(labels.shape, bool)
    row, column = int(np.floor(y)), int(np.floor(x))
    if not (0 <= row < labels.shape[0] and 0 <= column < labels.shape[1]):
        return piece
    alike = labels == labels[row, column]
    if regions is not None and regions[row, column] > 0:
        alike &= regions == regions[row, column]
    # filled with 2 from the point on
    filled = alike.astype(np.uint8)
    cv2.floodFill(filled, None, (column, row), 2, flags=4)
    np.equal(filled, 2, out=piece)
    return piece
