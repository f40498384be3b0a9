"""Islands, slivers and holes: finding them, and giving them to where they belong."""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ...blocks import Box
from ...edges.pairs import sides
from .patches import LabelPatch, Labels, Mask, free_of, grown, patch_within

_ROUGHNESS = 4
"""Thin bits of a block of up to so many pixels are the roughness of its outline, no slivers."""

_THICK = np.ones((3, 3), np.uint8)
"""Where a square of this size fits, a block is not thin."""

_PASSES = 4
"""How often is looked again, as what is thin may lie beside what has just changed hands."""


def clean_up(labels: Labels, smallest: int, locked: Collection[int] = (), box: Box | None = None) -> LabelPatch | None:
    """Give islands, slivers and holes of fewer than `smallest` pixels to the neighbour with the longest border to each.

    Islands are connected parts of a block that are too small, be it all of it; slivers are thin bits that stick out of
    a block (not those that connect two parts of it, nor the roughness of outlines); holes are pixels of no block that
    blocks go around. No block counts as a neighbour only where there is no other.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    smallest : int
        Pixels from which on they are left as they are.
    locked : collection of int
        Blocks that must not change: they are not cleaned up and take nothing in.
    box : tuple of slice, optional
        Where to look; everywhere if left out. What reaches far beyond it stays.
    """
    looked_at, seen = _seen(labels, smallest, box)
    after = seen.copy()
    for _ in range(_PASSES):
        areas, faulty = _faults(after, smallest, looked_at, labels.shape)
        if not faulty.any():
            break
        cleaned = _given_away(after, areas, faulty, locked)
        if np.array_equal(cleaned, after):
            break
        after = cleaned
    return patch_within(looked_at, seen, after)


def count_slivers(labels: Labels, smallest: int, box: Box | None = None, locked: Collection[int] = ()) -> int:
    """How many islands, slivers and holes `clean_up` would find at a first look, in all or in and around a box."""
    looked_at, seen = _seen(labels, smallest, box)
    areas, faulty = _faults(seen, smallest, looked_at, labels.shape)
    if locked and faulty.any():
        faulty[areas[~free_of(seen, locked)]] = False
    return int(np.count_nonzero(faulty))


def _seen(labels: Labels, smallest: int, box: Box | None) -> tuple[Box, Labels]:
    whole = slice(0, labels.shape[0]), slice(0, labels.shape[1])
    looked_at = whole if box is None else grown(box, min(max(smallest, 8), 32), labels.shape)
    return looked_at, labels[looked_at]


def _faults(labels: Labels, smallest: int, box: Box, shape: tuple[int, ...]) -> tuple[NDArray[np.int32], Mask]:
    """Connected areas that are either whole parts of blocks, or thin bits of them, and which of those are faults."""
    parts = _regions(labels)
    sizes = np.bincount(parts.ravel())
    open_ended = np.zeros(sizes.size, bool)
    for at_frame, line in zip(_at_frame(box, shape), _rim(parts), strict=True):
        if not at_frame:
            open_ended[line] = True
    small = (sizes < smallest) & ~open_ended
    small[0] = False
    for line, none in zip(_rim(parts), _rim(labels), strict=True):  # what blocks do not go around is no hole
        small[line[none == 0]] = False

    thick = _thick(labels)
    bits = _regions(np.where(thick, 0, parts), background=0)
    thin = np.bincount(bits.ravel())
    slivers = (thin < smallest) & (thin > _ROUGHNESS)
    slivers[0] = False
    # where the crop ends, what is thin cannot be told; and no block has no slivers
    for at_frame, line in zip(_at_frame(box, shape), _rim(bits), strict=True):
        if not at_frame:
            slivers[line] = False
    slivers[bits[labels == 0]] = False
    slivers[bits[small[parts]]] = False
    if slivers.any():
        bodies = _regions(np.where(thick, parts, 0), background=0)
        slivers &= _bodies_beside(np.where(slivers[bits], bits, 0), bodies, parts, slivers.size) == 1

    areas = np.where(slivers[bits], bits + sizes.size, parts).astype(np.int32)
    faulty = np.concatenate([small, slivers])
    return areas, faulty


def _regions(values: NDArray[np.int32], background: int = -1) -> NDArray[np.int32]:
    return np.asarray(connected_regions(values, background=background, connectivity=1), np.int32)


def _thick(labels: Labels) -> Mask:
    """Pixels that lie in some square of their own label."""
    number = labels.astype(np.float64)
    alike = (cv2.erode(number, _THICK) == number) & (cv2.dilate(number, _THICK) == number)
    return cv2.dilate(alike.astype(np.uint8), _THICK) > 0


def _at_frame(box: Box, shape: tuple[int, ...]) -> tuple[bool, bool, bool, bool]:
    rows, columns = box
    return rows.start == 0, rows.stop == shape[0], columns.start == 0, columns.stop == shape[1]


def _rim(values: NDArray[np.int32]) -> tuple[NDArray[np.int32], ...]:
    return values[0], values[-1], values[:, 0], values[:, -1]


def _bodies_beside(
    bits: NDArray[np.int32], bodies: NDArray[np.int32], parts: NDArray[np.int32], count: int
) -> NDArray[np.intp]:
    """How many thick bodies of its own part each of `count` thin bits touches."""
    found = []
    for (bit, beyond), (body_before, body), (one, other) in zip(sides(bits), sides(bodies), sides(parts), strict=True):
        for first, second in ((bit, body), (beyond, body_before)):
            touching = (first > 0) & (second > 0) & (one == other)
            found.append(np.stack([first[touching], second[touching]], axis=1))
    pairs = np.unique(np.concatenate(found), axis=0)
    return np.bincount(pairs[:, 0], minlength=count)


def _given_away(labels: Labels, areas: NDArray[np.int32], faulty: Mask, locked: Collection[int]) -> Labels:
    """The map in which every fault has the label of the neighbour with the longest border to it."""
    found = []
    for (one, other), (area, beyond), (open_one, open_other) in zip(
        sides(labels), sides(areas), sides(free_of(labels, locked)), strict=True
    ):
        movable = (one != other) & open_one & open_other
        for fault, rest, gains in ((area, beyond, other), (beyond, area, one)):
            # a fault beside another waits until that has gone
            given = movable & faulty[fault] & ~faulty[rest]
            found.append(np.stack([fault[given], gains[given]], axis=1))
    pairs, lengths = np.unique(np.concatenate(found), axis=0, return_counts=True)
    if not len(pairs):
        return labels
    order = np.lexsort((lengths, pairs[:, 1] > 0))  # of each fault the last counts: blocks, then length
    goes_to = np.full(faulty.size, -1, np.int32)
    goes_to[pairs[order, 0]] = pairs[order, 1]
    new = goes_to[areas]
    return np.where(new >= 0, new, labels).astype(np.int32)
