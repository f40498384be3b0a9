"""Pixels marked over the dimmed colour image."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_DIMMED = 0.55
_OPACITY = 0.75
"""Of the marks: what they lie on shows through."""


def dimmed(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The colour image, uint8 (H, W, 3), darker."""
    return np.asarray(cv2.convertScaleAbs(rgb, alpha=_DIMMED), np.uint8)


def tint(picture: NDArray[np.uint8], where: NDArray[np.bool_], colour: tuple[int, int, int]) -> None:
    """Mark pixels, bool (H, W), of a picture, uint8 (H, W, 3), in place."""
    tinted = cv2.addWeighted(np.full_like(picture, colour), _OPACITY, picture, 1 - _OPACITY, 0)
    cv2.copyTo(tinted, where.view(np.uint8), picture)


def marked_picture(rgb: NDArray[np.uint8], where: NDArray[np.bool_], colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """The dimmed colour image with some pixels marked.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    where : ndarray of bool, shape (H, W)
    colour : tuple of int
        (R, G, B) of the marks.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)

    Examples
    --------
    >>> import numpy as np
    >>> marked_picture(np.full((1, 2, 3), 100, np.uint8), np.array([[False, True]]), (200, 0, 0)).tolist()
    [[[55, 55, 55], [164, 14, 14]]]
    """
    picture = dimmed(rgb)
    tint(picture, where, colour)
    return picture
