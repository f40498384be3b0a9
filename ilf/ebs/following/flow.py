"""Sources by optical flow: what looks alike, from frame to frame."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ...frame import RGBDFrame
from .sources import Field, Mask, Sources, Whole, nearest

_SIDE = 24
"""Pictures are at least so high and wide [px] for flow: its patches need room."""

_BACK, _BACK_SHARE = 1.0, 0.05
"""How far from where it came from [px] a pixel may be led by going there and back, to be sure; grows by a share of the
motion."""

_LOST = 3.0
"""Beyond so many times that, what is there now was not seen before."""

_TEAR, _BESIDE_TEAR = 0.5, 7
"""Change of the motion from pixel to pixel [px] that parts two motions, and the side of the squares [px] around in
which the flow's patches mix them."""

_JUMP, _JUMP_SHARE = 0.05, 0.05
"""How far [m] depth may be off what it was, less the motion of what is around, and the same as a share of the depth:
the larger of the two."""

_AROUND, _ENOUGH = 31, 0.05
"""Side [px] of the squares over which the motion in depth is averaged, and share of them that must take part."""

_NEARBY, _NEARBY_SHARE = 0.2, 0.1
"""Pixels take part in it whose motion is off the usual by less than this [m], or this share of the depth."""


def by_flow(before: RGBDFrame, after: RGBDFrame) -> Sources:
    """Dense inverse search from the frame after to the one before, checked by going back, and by the depth."""
    there, back = flow_between(after, before), flow_between(before, after)
    height, width = after.shape
    rows, columns = np.indices((height, width), dtype=np.float32)
    columns += there[..., 0]
    rows += there[..., 1]
    row, column, inside = nearest(columns, rows)
    returned = cv2.remap(back, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    off = np.hypot(there[..., 0] + returned[..., 0], there[..., 1] + returned[..., 1])
    allowed = _BACK + _BACK_SHARE * np.hypot(there[..., 0], there[..., 1])
    other, same = _surfaces(before, after, row, column)
    lost = (off > _LOST * allowed) & ~same
    seen = inside & ~lost & ~other
    return Sources(row, column, seen, seen & (off <= allowed) & ~_torn(there), np.zeros((height, width), bool))


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


def _torn(flow: Field) -> Mask:
    """Pixels beside which the motion changes abruptly."""
    square = np.ones((3, 3), np.uint8)
    change = (cv2.dilate(flow, square) - cv2.erode(flow, square)).max(axis=2) > 2 * _TEAR
    return cv2.dilate(change.astype(np.uint8), np.ones((_BESIDE_TEAR, _BESIDE_TEAR), np.uint8)) > 0


def _surfaces(before: RGBDFrame, after: RGBDFrame, row: Whole, column: Whole) -> tuple[Mask, Mask]:
    """Where the depth says that another surface is seen than at the source, and where that it is the same."""
    source = before.depth[row, column]
    change = after.depth - source
    known = np.isfinite(change)
    if not known.any():
        return np.zeros(known.shape, bool), np.zeros(known.shape, bool)
    # what the camera's own motion changes is much alike among neighbours
    usual = np.float32(np.median(change[known]))
    near = known & (np.abs(change - usual) <= np.maximum(_NEARBY, _NEARBY_SHARE * np.nan_to_num(source)))
    weight = cv2.blur(near.astype(np.float32), (_AROUND, _AROUND))
    local = cv2.blur(np.where(near, change, np.float32(0)), (_AROUND, _AROUND)) / np.maximum(weight, np.float32(1e-6))
    with np.errstate(invalid="ignore"):
        off = np.abs(change - np.where(weight > _ENOUGH, local, usual))
        allowed = np.maximum(_JUMP, _JUMP_SHARE * np.fmin(source, after.depth))
        other, same = off > allowed, off <= allowed / 2
    return cv2.morphologyEx(other.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0, same
