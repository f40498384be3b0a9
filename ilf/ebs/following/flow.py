"""Motion by optical flow: what looks alike, from frame to frame."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from ...stopping import check_stopped
from .parts import Parts, nearest_in_part
from .sources import Field, Mask, Motion

_SIDE = 24
"""Pictures are at least so high and wide [px] for flow: its patches need room."""

_BACK, _BACK_SHARE = 1.0, 0.05
"""How far from where it came from [px] a pixel may be led by going there and back; grows by a share of the motion."""

_FAR = 0.5
"""Share of the picture that must agree; where less does, it may have moved far."""

_INSIDE = 4.0
"""From so far [px] inside a part on, the flow's patches see that part alone."""

_BESIDE = 2.0
"""Up to so far [px] from the border of a part, depth may be that of another."""


def by_flow(flow: Field, agrees: Mask, parts: Parts, depth: Field) -> Motion:
    """Motion along the flow. Parts move to their rims as they do inside, where the flow agrees with itself.

    Parameters
    ----------
    flow : ndarray of float32, shape (H, W, 2)
        From the frame before to the one after.
    agrees : ndarray of bool, shape (H, W)
        Where it can be relied on.
    parts : Parts
        Of the frame before.
    depth : ndarray of float32, shape (H, W)
        Depth of the parts [m]: of two that move to the same place, the nearer one is seen.
    """
    source = nearest_in_part(parts.map, agrees & (parts.reach > _INSIDE))
    thin = nearest_in_part(parts.map, agrees & (source < 0))
    source = np.where(source < 0, thin, source)
    rows, columns = np.indices(depth.shape, dtype=np.float32)
    own = np.arange(source.size).reshape(source.shape)
    inner = flow.reshape(-1, 2)[np.where(source < 0, own, source)]
    return Motion(columns + inner[..., 0], rows + inner[..., 1], depth, source >= 0)


def flows_between(before: RGBDFrame, after: RGBDFrame) -> tuple[Field, Mask]:
    """Where the pixels of the frame before are found in the one after, and where that agrees with the way back.

    Where the pictures have moved too far for that, it is looked for again from where they are most alike as a whole.

    Returns
    -------
    ndarray of float32, shape (H, W, 2)
        Offsets x, y [px].
    ndarray of bool, shape (H, W)
    """
    pictures = _brightness(before), _brightness(after)
    found = _there_and_back(*pictures, (0.0, 0.0))
    if np.count_nonzero(found[1]) < _FAR * found[1].size:
        window = cv2.createHanningWindow(pictures[0].shape[::-1], cv2.CV_32F)
        start, end = (picture.astype(np.float32) for picture in pictures)
        shift, _ = cv2.phaseCorrelate(start, end, window)
        again = _there_and_back(*pictures, (float(shift[0]), float(shift[1])))
        if np.count_nonzero(again[1]) > np.count_nonzero(found[1]):
            found = again
    height, width = before.shape
    return found[0][:height, :width], found[1][:height, :width]


def _there_and_back(start: NDArray[np.uint8], end: NDArray[np.uint8], shift: tuple[float, float]) -> tuple[Field, Mask]:
    """Flow from one picture to another, beginning with a shift [px] of all, and where the way back agrees."""
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    guess = np.empty((*start.shape, 2), np.float32)
    guess[:] = shift
    there = np.asarray(search.calc(start, end, guess.copy()), np.float32)
    check_stopped()
    back = np.asarray(search.calc(end, start, -guess), np.float32)
    check_stopped()
    rows, columns = np.indices(start.shape, dtype=np.float32)
    returned = cv2.remap(
        back, columns + there[..., 0], rows + there[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    off = np.hypot(there[..., 0] + returned[..., 0], there[..., 1] + returned[..., 1])
    return there, np.asarray(off <= _BACK + _BACK_SHARE * np.hypot(there[..., 0], there[..., 1]), bool)


def _brightness(frame: RGBDFrame) -> NDArray[np.uint8]:
    """Brightness, uint8, of a picture that is large enough for flow."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    below, right = (max(0, _SIDE - side) for side in frame.shape)
    return np.asarray(cv2.copyMakeBorder(grey, 0, below, 0, right, cv2.BORDER_REPLICATE), np.uint8)


def depth_of_parts(frame: RGBDFrame, parts: Parts) -> Field:
    """Known depth [m], and where it is missing or beside a border that of the nearest pixel of the same part; NaN in
    parts of which nothing is known."""
    source = nearest_in_part(parts.map, frame.known & (parts.reach > _BESIDE))
    thin = nearest_in_part(parts.map, frame.known & (source < 0))
    source = np.where(source < 0, thin, source)
    return np.where(source < 0, np.float32(np.nan), frame.depth.ravel()[source])
