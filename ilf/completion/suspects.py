"""Suspect depth: small islands of known depth in missing depth, far off all surfaces there. The preset `best` leaves
them out of the fill."""

from __future__ import annotations

from functools import cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.blocks import Block, grown
from ..data.frame import RGBDFrame
from ..data.frame_cache import once_per_frame
from ..data.parameters import Parameters
from ..data.pixel_grids import distance_to

Mask = NDArray[np.bool_]

_LARGEST, _LARGEST_SHARE = 250, 0.0008
"""Maximum size of an island: the larger of the two [px, share of the frame]."""

_GAP, _KNOWN = 8, 0.2
"""Of the pixels up to this distance [px] from an island, at most this share is known: a small thing in front of a wall
has the wall closer to it, on at least one side."""

_AROUND, _LEAST = 32, 50
"""The surfaces around an island are known depth up to so many pixels farther from it than the nearest of it; there are
at least so many pixels of them, and more than the island has."""

_SURFACE = 3
"""Surfaces consist of squares of this side [px] that are all known: lines, points and scattered samples are none, since
in sparse depth islands are the data."""

_FAR_OFF = 1.5
"""Minimum ratio of an island's depth and that of all surfaces around it."""

_SUPPORT = 0.25
"""Distance, as a share of the frame's longer side, up to which other known depth within that ratio, of more pixels than
an island may have, supports an island: it shows that something there has such depth."""


@once_per_frame
def suspect_islands(frame: RGBDFrame) -> Mask:
    """Find small islands of known depth, surrounded by missing depth, far off the surfaces around them and unlike any
    known depth near by; bool (H, W).

    Examples
    --------
    >>> depth = np.full((60, 80), 0.7)
    >>> depth[10:50, 20:60] = np.nan
    >>> depth[28:32, 38:42] = 12.0
    >>> frame = RGBDFrame(np.zeros((60, 80, 3), np.uint8), depth)
    >>> int(suspect_islands(frame).sum()), frame.depth[30, 40]
    (16, np.float32(12.0))
    """
    known, depth = frame.known, frame.depth
    suspect = np.zeros(frame.shape, bool)
    _, parts, boxes, _ = cv2.connectedComponentsWithStats(known.view(np.uint8), connectivity=8)
    sizes = boxes[:, cv2.CC_STAT_AREA]
    largest = max(_LARGEST, _LARGEST_SHARE * depth.size)
    small = sizes <= largest
    small[0] = False  # missing depth
    square, large = np.ones((_SURFACE, _SURFACE), np.uint8), (known & ~small[parts]).view(np.uint8)
    surfaces = cv2.erode(large, square, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    if not (small.any() and surfaces.any()):
        return suspect
    away = cache(partial(distance_to, surfaces))
    for number in np.flatnonzero(small):
        x, y, width, height, size = boxes[number].tolist()
        own = slice(y, y + height), slice(x, x + width)
        box = grown(own, _GAP, frame.shape)
        island = parts[box] == number
        if known[box][(distance_to(island) <= _GAP) & ~island].mean() > _KNOWN:
            continue
        level = float(np.median(depth[box][island]))
        near_by = depth[grown(own, int(_SUPPORT * max(frame.shape)), frame.shape)]
        # support is the usual case, and some of the rows mostly show it
        if any(_alike(near_by[::step], level) - size >= largest for step in (8, 1)):
            continue
        reach = int(away()[own][parts[own] == number].min()) + _AROUND
        box = grown(own, reach, frame.shape)
        island = parts[box] == number
        around = depth[box][surfaces[box] & (distance_to(island) <= reach)]
        if around.size < max(_LEAST, size):
            continue
        low, high = np.quantile(around, (0.02, 0.98))
        if not low / _FAR_OFF <= level <= high * _FAR_OFF:
            suspect[box] |= island
    return suspect


def _alike(depth: NDArray[np.float32], level: float) -> int:
    """Number of pixels with depth like that of an island."""
    return int(np.count_nonzero((depth > level / _FAR_OFF) & (depth < level * _FAR_OFF)))


@once_per_frame
def without_suspects(frame: RGBDFrame) -> RGBDFrame:
    """The frame with its suspect islands marked as invalid; the frame itself without any."""
    islands = suspect_islands(frame)
    return frame.with_more_invalid(islands) if islands.any() else frame


def frame_for(frame: RGBDFrame, block: Block, parameters: Parameters) -> RGBDFrame:
    """The frame that a block is filled from: without suspect islands, unless they are all that the block has."""
    if parameters.filter != "edge-aware" or not parameters.jump_share:
        return frame
    trusted = without_suspects(frame)
    if trusted is frame:
        return frame
    there = frame.depth[block.box][block.mask]
    alone = np.isnan(trusted.depth[block.box][block.mask]).all() and np.isfinite(there).any()
    return frame if alone else trusted


def suspects_in(frame: RGBDFrame, block: Block, parameters: Parameters) -> Mask:
    """Pixels of a block whose known depth is left out of its fill, in the order of `block.mask`'s True values."""
    trusted = frame_for(frame, block, parameters)
    if trusted is frame:
        return np.zeros(np.count_nonzero(block.mask), bool)
    return frame.known[block.box][block.mask] & ~trusted.known[block.box][block.mask]
