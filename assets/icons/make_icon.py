"""Draw the program's icon: a surface whose hole the low pass closes, over a depth ramp.

    python assets/icons/make_icon.py

writes ilf-studio.png and ilf-studio.svg beside this script. The same come out every time.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

SIDE = 256
_OVERSAMPLING = 4
_CORNER = 0.22
_LEFT, _RIGHT, _HALF_WIDTH = 0.14, 0.86, 0.021
_HOLE = (0.54, 0.53), (0.19, 0.21)
"""Ends of the lines, and half of their vertical width; middle and half axes of the hole."""
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
        line = (np.abs(y - _line(level, x)) < _HALF_WIDTH) & (x > _LEFT) & (x < _RIGHT)
        (across, down), (width, height) = _HOLE
        hole = np.hypot((x - across) / width, (y - down) / height) < 1
        pixels[line & ~hole, :3] = _KNOWN
        pixels[line & hole, :3] = _FILLED
    return cv2.resize(pixels, (side, side), interpolation=cv2.INTER_AREA).round().astype(np.uint8)


def icon_svg() -> str:
    """The same icon as SVG, without clipping, which not every desktop draws."""
    x = np.linspace(_LEFT, _RIGHT, 97)
    (across, down), (width, height) = _HOLE
    paths = {True: "", False: ""}
    for level in range(5):
        hole = np.hypot((x - across) / width, (_line(level, x) - down) / height) < 1
        paths[False] += _stroke(level, x)
        paths[True] += _stroke(level, x[hole])
    near, far, known, filled = (f"#{bytes(colour.tolist()).hex()}" for colour in (_NEAR, _FAR, _KNOWN, _FILLED))
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}">
<linearGradient id="ramp" x1="0" y1="0" x2="0" y2="1">
<stop offset="0" stop-color="{near}"/><stop offset="1" stop-color="{far}"/>
</linearGradient>
<rect width="{SIDE}" height="{SIDE}" rx="{SIDE * _CORNER:.1f}" fill="url(#ramp)"/>
<path d="{paths[False]}" fill="{known}"/>
<path d="{paths[True]}" fill="{filled}"/>
</svg>
"""


def _stroke(level: int, x: NDArray[np.float64]) -> str:
    """A part of a line as a closed SVG path; "" without points."""
    if not x.size:
        return ""
    y = _line(level, x)
    upper, lower = np.stack([x, y - _HALF_WIDTH]), np.stack([x, y + _HALF_WIDTH])[:, ::-1]
    points = SIDE * np.concatenate([upper, lower], axis=1).T
    return f"M{' '.join(f'{across:.1f},{down:.1f}' for across, down in points)}Z"


def _line(level: int, x: NDArray[np.float64]) -> NDArray[np.float64]:
    """The middle of a line."""
    return 0.3 + 0.115 * level + 0.07 * np.sin(2 * np.pi * (x - 0.12 * level))


def _inside(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
    """A square with round corners."""
    beyond = [np.maximum(np.abs(axis - 0.5) - (0.5 - _CORNER), 0) for axis in (x, y)]
    return np.hypot(*beyond) <= _CORNER


if __name__ == "__main__":
    target = Path(__file__).with_name("ilf-studio.png")
    cv2.imwrite(str(target), cv2.cvtColor(draw_icon(), cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    target.with_suffix(".svg").write_text(icon_svg())
