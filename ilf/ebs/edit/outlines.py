"""A block's outline moved outwards, inwards, or made smooth."""

from __future__ import annotations

import math
from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from .patches import LabelPatch, Labels, Mask, box_of, free_of, patch_within


def grow(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give a block all pixels within `px` pixels of it, except those of locked blocks."""
    box = _box(labels, label, px, locked)
    if box is None:
        return None
    before = labels[box]
    gained = (_distance(before == label) <= px) & free_of(before, locked)
    return patch_within(box, before, np.where(gained, label, before).astype(np.int32))


def shrink(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Take from a block all pixels within `px` pixels of its outline; its sides along the frame's rim stay.

    They go to the nearest block beside it that is not locked; to none where there is none that near. Along a locked
    block the outline stays. None if nothing of the block would be left.
    """
    box = _box(labels, label, px, locked)
    if box is None:
        return None
    before = labels[box]
    block = before == label
    lost = block & (_distance(~block & free_of(before, locked)) <= px)
    return _let_go(box, before, label, lost, px, locked)


def smooth(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Smooth a block's outline: what is finer than about `px` pixels goes, straight stretches stay.

    A pixel belongs to the block if most of what lies around it does, by a Gaussian of that standard deviation. The
    neighbours follow, except locked ones. None if nothing of the block would be left.
    """
    box = _box(labels, label, 3 * px, locked)
    if box is None:
        return None
    before = labels[box]
    block = before == label
    free = free_of(before, locked)
    around = cv2.GaussianBlur(block.astype(np.float32), (0, 0), px, borderType=cv2.BORDER_REPLICATE)
    gained = ~block & free & (around > 0.5)
    lost = block & (around < 0.5)
    return _let_go(box, np.asarray(before), label, lost, 3 * px, locked, gained)


def _box(labels: Labels, label: int, px: float, locked: Collection[int]) -> tuple[slice, slice] | None:
    if label <= 0 or label in locked or px <= 0:
        return None
    return box_of(labels, label, rim=math.ceil(px) + 2)


def _distance(mask: Mask) -> NDArray[np.float32]:
    """Distance [px] to the nearest pixel of a mask; beyond all bounds where there is none."""
    if not mask.any():
        return np.full(mask.shape, np.inf, np.float32)
    outside = (~mask).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(outside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float32)


def _let_go(
    box: tuple[slice, slice],
    before: Labels,
    label: int,
    lost: Mask,
    px: float,
    locked: Collection[int],
    gained: Mask | None = None,
) -> LabelPatch | None:
    """Pixels that a block loses go to the nearest block, or to none; those that it gains are its."""
    block = before == label
    if not (block & ~lost).any():
        return None
    after = before.copy()
    beside = ~block & free_of(before, locked)
    if lost.any() and beside.any():
        after[lost] = 0
        takers = beside & (before > 0)
        if takers.any():
            distance, (rows, columns) = distance_transform_edt(~takers, return_indices=True)
            near = lost & (distance <= px + 1.5)
            after[near] = before[rows[near], columns[near]]
    if gained is not None:
        after[gained] = label
    return patch_within(box, before, after)
