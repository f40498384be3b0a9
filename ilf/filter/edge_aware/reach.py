"""Holes that begin where the sensor's reach ends: what is missing there lies beyond all that is known around."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...blocks import Block
from ...frame import RGBDFrame
from ...per_frame import once_per_frame
from .guiding import fit_guide
from .own_word import around_wide_gaps

Mask = NDArray[np.bool_]

_REACH_SHARE = 0.99
"""So much of a frame's known depth lies within the reach."""

_AT_REACH = 0.98
"""Known depth is at the reach from so much of it on."""

_RIM, _LEAST_RIM = 4, 20
"""The rim of a hole is the block's known depth up to so many pixels from it, and has so many pixels. Its median, the
hole's limit, must be at the reach."""

_DENSE = 0.5
"""So much of what is up to that far from the hole must be known: where depth is thin everywhere, rims say little."""

_BACK = 8, 24
"""Between these distances [px] from a hole lies the block's known depth that its rim must rise above."""

_RISING = 1.03
"""By how much, in medians."""

_NEARER = 0.85
"""Known depth beside the hole that is less than so much of its limit belongs to something in front."""


@dataclass(frozen=True, eq=False)
class Beyond:
    """Holes of a block that lie beyond the sensor's reach, as their rims say.

    Attributes
    ----------
    pixels : ndarray of bool, shape (H, W)
        The block's missing pixels there.
    in_front : ndarray of bool, shape (H, W)
        Known pixels beside them, of whatever block, of something in front.
    limit : float
        Depth [m] at which the nearest of the holes begins.
    """

    pixels: Mask
    in_front: Mask
    limit: float


@once_per_frame
def reach_of(frame: RGBDFrame) -> float:
    """Depth [m] beyond which the frame knows hardly any."""
    return float(np.quantile(frame.depth[frame.known], _REACH_SHARE))


def beyond_reach(frame: RGBDFrame, block: Block) -> Beyond | None:
    """Wide holes of a block whose rims rise to the sensor's reach; None if there is none, or if a guide that known
    depth bears out tells what lies there.

    Nothing that was measured vouches for what is filled in there.
    """
    guide = fit_guide(frame)
    if guide is not None and guide.carries(block):
        return None
    at_reach = _AT_REACH * reach_of(frame)
    if not (frame.depth[block.box][block.mask] >= at_reach).any():
        return None
    rows, columns = (slice(max(side.start - _BACK[1], 0), side.stop + _BACK[1]) for side in block.box)
    depth, known = frame.depth[rows, columns], frame.known[rows, columns]
    inside = np.zeros(frame.shape, bool)
    inside[block.box] = block.mask
    distance = cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 5).astype(np.float32, copy=False)
    missing = inside[rows, columns] & ~known & around_wide_gaps(distance)
    count, holes, boxes, _ = cv2.connectedComponentsWithStats(missing.astype(np.uint8), connectivity=4)
    pixels, in_front, limits = np.zeros(frame.shape, bool), np.zeros(frame.shape, bool), []
    for number in range(1, count):
        x, y, width, height = boxes[number, :4]
        part = np.s_[max(y - _BACK[1], 0) : y + height + _BACK[1], max(x - _BACK[1], 0) : x + width + _BACK[1]]
        hole, there = holes[part] == number, depth[part]
        own = inside[rows, columns][part] & known[part]
        off = cv2.distanceTransform((~hole).astype(np.uint8), cv2.DIST_L2, 5)
        rim, back = there[own & (off <= _RIM)], there[own & (off > _BACK[0]) & (off <= _BACK[1])]
        if rim.size < _LEAST_RIM or back.size == 0 or known[part][(off <= _RIM) & ~hole].mean() < _DENSE:
            continue
        limit = float(np.median(rim))
        if limit < max(at_reach, _RISING * float(np.median(back))):
            continue
        pixels[rows, columns][part] |= hole
        in_front[rows, columns][part] |= (off <= _BACK[0]) & (there < _NEARER * limit)
        limits.append(limit)
    return Beyond(pixels, in_front, min(limits)) if limits else None
