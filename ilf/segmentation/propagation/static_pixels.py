"""Static pixels and static cameras, by colour and depth of two frames."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]

_BLUR = 1.2
"""Blur [px] before colours are compared, which removes most of a sensor's noise."""

_NOISES = 5.0
"""Changes above this number of standard deviations are not noise."""

_LEAST_COLOUR = 4.0
"""Smallest change of brightness [of 255] that counts."""

_LEAST_DEPTH, _DEPTH_SHARE = 0.05, 0.03
"""Smallest change of depth that counts: the larger of a distance [m] and a fraction of the depth."""

_STILL_AROUND = 9
"""Side [px] of the squares around changed pixels that are not static either."""

_DETAIL = 8.0
"""Minimum gradient of brightness [per px] at which a motion is visible."""

_CELLS, _LEAST_DETAIL = 8, 40
"""Number of cells along each side of the image, and minimum number of pixels with detail for a cell to count."""

_MOTION, _SHARE = 0.06, 0.6
"""A cell is static if its median motion is less than this [px]; the camera is static if this fraction of the cells is.
"""

MAX_STATIC_CHANGE = 0.001
"""Maximum fraction of changed pixels for a static scene before a static camera."""


def changed(before: RGBDFrame, after: RGBDFrame) -> Mask:
    """Pixels whose colour or depth has changed, bool (H, W)."""
    off = np.abs(brightness(after) - brightness(before))
    # a drift of exposure is not motion
    off = np.abs(off - np.median(off)) if np.median(off) > 1 else off
    noise = 1.4826 * float(np.median(off))
    colour = off > max(_LEAST_COLOUR, _NOISES * noise)
    both = before.known & after.known
    with np.errstate(invalid="ignore"):
        least = np.maximum(_LEAST_DEPTH, _DEPTH_SHARE * np.minimum(before.depth, after.depth))
        depth = both & (np.abs(before.depth - after.depth) > least)
    # single pixels are noise, and depth flickers along edges
    return _opened(colour, 3) | _opened(depth, 5)


def _opened(mask: Mask, side: int) -> Mask:
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((side, side), np.uint8)) > 0


def around(mask: Mask) -> Mask:
    """A dilated mask."""
    return cv2.dilate(mask.astype(np.uint8), np.ones((_STILL_AROUND, _STILL_AROUND), np.uint8)) > 0


def camera_is_static(before: RGBDFrame, flow: Field) -> bool:
    """Whether most of the image's detail is static, by the flow to the frame after, float32 (H, W, 2)."""
    motions = [float(np.hypot(*np.median(there, axis=0))) for there in in_cells(flow, detailed(before))]
    # without any detail, there is no evidence of motion
    return not motions or float(np.quantile(motions, _SHARE)) < _MOTION


def in_cells(values: Field, mask: Mask) -> Iterator[Field]:
    """Values at the pixels of a mask, cell by cell of the image, for cells with enough of them."""
    for rows, parts in zip(np.array_split(mask, _CELLS), np.array_split(values, _CELLS), strict=True):
        cells = zip(np.array_split(rows, _CELLS, axis=1), np.array_split(parts, _CELLS, axis=1), strict=True)
        yield from (part[here] for here, part in cells if np.count_nonzero(here) >= _LEAST_DETAIL)


def detailed(frame: RGBDFrame) -> Mask:
    """Pixels with enough detail to show a motion, bool (H, W)."""
    grey = brightness(frame)
    return np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)) / 8 > _DETAIL


def brightness(frame: RGBDFrame) -> NDArray[np.float32]:
    """Brightness 0-255, blurred, float32 (H, W)."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), _BLUR), np.float32)
