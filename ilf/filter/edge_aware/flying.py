"""Flying pixels: samples that the known depth around them does not bear out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from ...per_frame import once_per_frame

_REACH = 2
"""Neighbours are the pixels up to so many pixels away along each axis."""

_LIKE = 0.05
"""Samples are alike if they differ by less than this share of their depth."""

_FEW = 8
"""With fewer known neighbours than that, a sample is all there is."""

_LEAST_SHARE = 0.1
"""A sample flies if no larger share of its known neighbours is like it: a line that is one pixel wide does not."""


@once_per_frame
def flying_pixels(frame: RGBDFrame) -> NDArray[np.bool_]:
    """Known pixels that hardly any known neighbour is like, bool (H, W)."""
    height, width = frame.shape
    known = frame.known
    depth = np.where(known, frame.depth, np.float32(0))
    neighbours, alike = np.zeros(frame.shape, np.uint8), np.zeros(frame.shape, np.uint8)
    for dy in range(_REACH + 1):
        for dx in range(-_REACH, _REACH + 1):
            if (dy, dx) <= (0, 0):
                continue  # every pair once
            here = np.s_[: height - dy, max(0, -dx) : min(width, width - dx)]
            there = np.s_[dy:, max(0, dx) : min(width, width + dx)]
            both = known[here] & known[there]
            near = np.abs(depth[here] - depth[there]) < np.float32(_LIKE) * np.minimum(depth[here], depth[there])
            near &= both
            for part in (here, there):
                neighbours[part] += both
                alike[part] += near
    return known & (neighbours >= _FEW) & (alike <= np.float32(_LEAST_SHARE) * neighbours)
