"""Draw the program's icon: a surface whose hole the low pass closes, over a depth ramp.

    python assets/icons/make_icon.py

writes ilf-studio.png beside this script. The same pixels come out every time.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

SIDE = 256
_OVERSAMPLING = 4
_CORNER = 0.22
_NEAR, _FAR = np.array([74, 163, 240]), np.array([24, 52, 108])
_KNOWN, _FILLED = np.array([245, 247, 250]), np.array([255, 176, 64])


def draw_icon(side: int = SIDE) -> NDArray[np.uint8]:
    """The icon, uint8 (side, side, 4) RGBA."""
    large = side * _OVERSAMPLING
    y, x = (np.mgrid[:large, :large] + 0.5) / large
    pixels = np.empty((large, large, 4))
    pixels[..., :3] = _NEAR + (_FAR - _NEAR) * y[..., None]
    pixels[..., 3] = 255 * _inside(x, y)
    for level in range(5):
        height = 0.3 + 0.115 * level
        line = np.abs(y - height - 0.07 * np.sin(2 * np.pi * (x - 0.12 * level))) < 0.021
        line &= (x > 0.14) & (x < 0.86)
        hole = np.hypot((x - 0.54) / 0.19, (y - 0.53) / 0.21) < 1
        pixels[line & ~hole, :3] = _KNOWN
        pixels[line & hole, :3] = _FILLED
    return cv2.resize(pixels, (side, side), interpolation=cv2.INTER_AREA).round().astype(np.uint8)


def _inside(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """A square with round corners."""
    beyond = [np.maximum(np.abs(axis - 0.5) - (0.5 - _CORNER), 0) for axis in (x, y)]
    return np.hypot(*beyond) <= _CORNER


if __name__ == "__main__":
    target = Path(__file__).with_name("ilf-studio.png")
    cv2.imwrite(str(target), cv2.cvtColor(draw_icon(), cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_PNG_COMPRESSION, 9])
