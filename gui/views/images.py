"""Arrays to Qt images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage


def rgb_image(rgb: NDArray[np.uint8]) -> QImage:
    """An image that owns its pixels, from uint8 (H, W, 3), red first."""
    pixels = np.ascontiguousarray(rgb)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()


def image_over(pixels: NDArray[np.uint32], form: QImage.Format) -> QImage:
    """An image over the very memory of an array (H, W), which has to live as long, of a format of 4 bytes a pixel."""
    height, width = pixels.shape
    return QImage(pixels.data, width, height, 4 * width, form) if pixels.size else QImage()
