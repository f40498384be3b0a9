"""Motion by optical flow: what looks alike, from frame to frame."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from .parts import Parts, nearest_in_part
from .sources import Field, Motion

_SIDE = 24
"""Pictures are at least so high and wide [px] for flow: its patches need room."""

_BACK, _BACK_SHARE = 1.0, 0.05
"""How far from where it came from [px] a pixel may be led by going there and back; grows by a share of the motion."""

_INSIDE = 4.0
"""From so far [px] inside a part on, the flow's patches see that part alone."""

_BESIDE = 2.0
"""Up to so far [px] from the border of a part, depth may be that of another."""


def by_flow(there: Field, back: Field, parts: Parts, depth: Field) -> Motion:
    """Motion along the flow, where going there and back agrees. Parts move to their rims as they do inside.

    Parameters
    ----------
    there, back : ndarray of float32, shape (H, W, 2)
        `flow_between` the frames, from the one before to the one after, and the other way.
    parts : Parts
        Of the frame before.
    depth : ndarray of float32, shape (H, W)
        Depth of the parts [m]: of two that move to the same place, the nearer one is seen.
    """
    rows, columns = np.indices(depth.shape, dtype=np.float32)
    returned = cv2.remap(
        back, columns + there[..., 0], rows + there[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    off = np.hypot(there[..., 0] + returned[..., 0], there[..., 1] + returned[..., 1])
    agrees = off <= _BACK + _BACK_SHARE * np.hypot(there[..., 0], there[..., 1])
    source = nearest_in_part(parts.map, agrees & (parts.reach > _INSIDE))
    thin = nearest_in_part(parts.map, agrees & (source < 0))
    source = np.where(source < 0, thin, source)
    own = np.arange(source.size).reshape(source.shape)
    inner = there.reshape(-1, 2)[np.where(source < 0, own, source)]
    return Motion(columns + inner[..., 0], rows + inner[..., 1], depth, source >= 0)


def flow_between(one: RGBDFrame, other: RGBDFrame) -> Field:
    """Where the pixels of one frame are found in another, as offsets x, y [px], float32 (H, W, 2)."""
    height, width = one.shape
    start, end = (_brightness(frame) for frame in (one, other))
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    found = search.calc(start, end, np.zeros((*start.shape, 2), np.float32))
    return np.asarray(found, np.float32)[:height, :width]


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
