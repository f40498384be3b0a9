"""OpenCV's inpainting, on depth in whole millimetres: it takes 16-bit images."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame

_RADIUS = 3.0
_UNITS = 1000.0
_DEEPEST = 65_535


def navier_stokes(frame: RGBDFrame) -> NDArray[np.float32]:
    """Bertalmio, Bertozzi and Sapiro, "Navier-Stokes, fluid dynamics, and image and video inpainting", 2001."""
    return _inpainted(frame, cv2.INPAINT_NS)


def telea(frame: RGBDFrame) -> NDArray[np.float32]:
    """Telea, "An image inpainting technique based on the fast marching method", 2004."""
    return _inpainted(frame, cv2.INPAINT_TELEA)


def _inpainted(frame: RGBDFrame, method: int) -> NDArray[np.float32]:
    millimetres = np.nan_to_num(frame.depth.astype(np.float64)) * _UNITS
    image = np.clip(np.rint(millimetres), 0, _DEEPEST).astype(np.uint16)
    filled = cv2.inpaint(image, (~frame.known).astype(np.uint8), _RADIUS, method)
    return np.where(filled > 0, filled / np.float32(_UNITS), np.float32(np.nan))
