"""What has not moved from one frame to the next, by colour and depth."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from .sources import Field, Mask

_BLUR = 1.2
"""Blur [px] before colours are compared, which takes out most of a sensor's noise."""

_NOISES = 5.0
"""Changes beyond so many standard deviations of the noise are none of it."""

_LEAST_COLOUR = 4.0
"""Smallest change of brightness [of 255] that counts."""

_LEAST_DEPTH, _DEPTH_SHARE = 0.05, 0.03
"""Smallest change of depth [m] that counts, and the same as a share of the depth: the larger of the two."""

_AROUND = 9
"""Side [px] of the squares around changes that are not still either."""

_DETAIL = 8.0
"""Gradient of brightness [per px] from which on a pixel would show a motion."""

_CELLS, _LEAST_DETAIL = 8, 40
"""The picture is divided into so many by so many cells, each of which is judged that has so many pixels with detail."""

_MOTION, _SHARE = 0.06, 0.6
"""A cell stays where it is if the median of its motion is less than this [px]; and the camera, if such a share of the
cells does."""

ALL_STILL = 0.001
"""Share of changed pixels up to which nothing has moved before a camera that is still."""


def changed(before: RGBDFrame, after: RGBDFrame) -> Mask:
    """Pixels of which colour or depth says that they show something else than before, bool (H, W)."""
    off = np.abs(brightness(after) - brightness(before))
    # exposure may drift a little, and is no motion
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
    """A mask with what is beside it."""
    return cv2.dilate(mask.astype(np.uint8), np.ones((_AROUND, _AROUND), np.uint8)) > 0


def camera_is_still(before: RGBDFrame, flow: Field) -> bool:
    """Whether most of the detail of the picture is where it was, by the flow to the frame after, float32 (H, W, 2)."""
    motions = [float(np.hypot(*np.median(there, axis=0))) for there in in_cells(flow, detailed(before))]
    # without any detail, nothing speaks for a motion
    return not motions or float(np.quantile(motions, _SHARE)) < _MOTION


def in_cells(values: Field, mask: Mask) -> Iterator[Field]:
    """Values at the pixels of a mask, cell by cell of the picture, for cells that have enough of them."""
    for rows, parts in zip(np.array_split(mask, _CELLS), np.array_split(values, _CELLS), strict=True):
        cells = zip(np.array_split(rows, _CELLS, axis=1), np.array_split(parts, _CELLS, axis=1), strict=True)
        yield from (part[here] for here, part in cells if np.count_nonzero(here) >= _LEAST_DETAIL)


def detailed(frame: RGBDFrame) -> Mask:
    """Pixels that would show a motion, bool (H, W)."""
    grey = brightness(frame)
    return np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)) / 8 > _DETAIL


def brightness(frame: RGBDFrame) -> NDArray[np.float32]:
    """Brightness 0-255, blurred, float32 (H, W)."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), _BLUR), np.float32)
