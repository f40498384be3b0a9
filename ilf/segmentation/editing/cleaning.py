"""Cleaning up islands, slivers and holes; growing, shrinking, smoothing, deleting and merging blocks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ...data.blocks import Box, bounds, grown, whole
from ...data.pixel_grids import connected_regions, neighbours, rim
from .borders import have_border
from .patches import LabelPatch, Labels, Mask, box_of, patch_between, patch_within, unlocked_pixels

_ROUGHNESS = 4
"""Thin parts of a block of up to this many pixels are roughness of its outline, not slivers."""

_THICK = np.ones((3, 3), np.uint8)
"""A block is not thin where a square of this size fits."""

_PASSES = 4
"""Number of passes, since thin parts may lie beside areas that were just reassigned."""


def clean_up(labels: Labels, smallest: int, locked: Collection[int] = (), box: Box | None = None) -> LabelPatch | None:
    """Give islands, slivers and holes of fewer than `smallest` pixels to the neighbour with the longest border to each.

    Islands are connected parts of a block that are too small, or the whole block; slivers are thin parts that stick out
    of a block (not those that connect two parts of it, nor the roughness of outlines); holes are pixels of no block
    that blocks enclose. "No block" is used as a neighbour only if there is no other.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    smallest : int
        Minimum number of pixels of areas that stay.
    locked : collection of int
        Blocks that must not change: they are not cleaned up and get no pixels.
    box : tuple of slice, optional
        Area to clean up; everywhere if left out. Areas that extend far beyond it stay.
    """
    crop, seen = _cropped(labels, smallest, box)
    after = seen.copy()
    for _ in range(_PASSES):
        areas, to_clean = _areas_to_clean(after, smallest, crop, labels.shape)
        if not to_clean.any():
            break
        cleaned = given_to_neighbours(after, areas, to_clean, locked)
        if np.array_equal(cleaned, after):
            break
        after = cleaned
    return patch_within(crop, seen, after)


def count_slivers(labels: Labels, smallest: int, box: Box | None = None, locked: Collection[int] = ()) -> int:
    """Number of islands, slivers and holes that the first pass of `clean_up` finds, in all or in and around a box."""
    crop, seen = _cropped(labels, smallest, box)
    areas, to_clean = _areas_to_clean(seen, smallest, crop, labels.shape)
    if locked and to_clean.any():
        to_clean[areas[~unlocked_pixels(seen, locked)]] = False
    return int(np.count_nonzero(to_clean))


def _cropped(labels: Labels, smallest: int, box: Box | None) -> tuple[Box, Labels]:
    crop = whole(labels.shape) if box is None else grown(box, min(max(smallest, 8), 32), labels.shape)
    return crop, labels[crop]


def _areas_to_clean(labels: Labels, smallest: int, box: Box, shape: tuple[int, ...]) -> tuple[NDArray[np.int32], Mask]:
    """Connected areas (whole parts of blocks, or their thin parts), and which of them are to be cleaned up."""
    parts = connected_regions(labels, background=-1)
    sizes = np.bincount(parts.ravel())
    open_ended = np.zeros(sizes.size, bool)
    open_ended[_cut_rim(parts, box, shape)] = True
    small = (sizes < smallest) & ~open_ended
    small[0] = False
    small[rim(parts)[rim(labels) == 0]] = False  # only areas enclosed by blocks are holes

    thick = _thick(labels)
    bits = connected_regions(np.where(thick, 0, parts))
    thin = np.bincount(bits.ravel())
    slivers = (thin < smallest) & (thin > _ROUGHNESS)
    slivers[0] = False
    # thinness is undefined where the crop ends; and "no block" has no slivers
    slivers[_cut_rim(bits, box, shape)] = False
    slivers[bits[labels == 0]] = False
    slivers[bits[small[parts]]] = False
    if slivers.any():
        bodies = connected_regions(np.where(thick, parts, 0))
        slivers &= _bodies_beside(np.where(slivers[bits], bits, 0), bodies, parts, slivers.size) == 1

    areas = np.where(slivers[bits], bits + sizes.size, parts).astype(np.int32)
    to_clean = np.concatenate([small, slivers])
    return areas, to_clean


def _thick(labels: Labels) -> Mask:
    """Pixels that lie in any square of their own label."""
    number = labels.astype(np.float64)
    alike = (cv2.erode(number, _THICK) == number) & (cv2.dilate(number, _THICK) == number)
    return cv2.dilate(alike.astype(np.uint8), _THICK) > 0


def _cut_rim(values: NDArray[np.int32], box: Box, shape: tuple[int, ...]) -> NDArray[np.int32]:
    """The values along the sides of a crop that are not sides of the frame."""
    rows, columns = box
    inside = rows.start > 0, rows.stop < shape[0], columns.start > 0, columns.stop < shape[1]
    lines = values[0], values[-1], values[:, 0], values[:, -1]
    return np.concatenate([values[:0, 0], *itertools.compress(lines, inside)])


def _bodies_beside(
    bits: NDArray[np.int32], bodies: NDArray[np.int32], parts: NDArray[np.int32], count: int
) -> NDArray[np.intp]:
    """Number of thick bodies of its own part that each of `count` thin parts touches."""
    found = []
    for (bit, _), (_, body), (one, other) in neighbours(bits, bodies, parts):
        touching = (bit > 0) & (body > 0) & (one == other)
        found.append(np.stack([bit[touching], body[touching]], axis=1))
    pairs = np.unique(np.concatenate(found), axis=0)
    return np.bincount(pairs[:, 0], minlength=count)


def given_to_neighbours(labels: Labels, areas: NDArray[np.int32], to_clean: Mask, locked: Collection[int]) -> Labels:
    """Give areas each to the neighbour with the longest border to it; of two that are adjacent, one waits.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    areas : ndarray of int32, shape (H, W)
        The number of the area at every pixel.
    to_clean : ndarray of bool, shape (N,)
        Which areas to give, by their number.
    locked : collection of int
        Blocks that neither lose nor get pixels.
    """
    found = []
    unlocked = unlocked_pixels(labels, locked)
    for (one, other), (area, beyond), (open_one, open_other) in neighbours(labels, areas, unlocked):
        # of two adjacent areas to clean up, one waits until the other is gone
        given = (one != other) & open_one & open_other & to_clean[area] & ~to_clean[beyond]
        found.append(np.stack([area[given], other[given]], axis=1))
    pairs, lengths = np.unique(np.concatenate(found), axis=0, return_counts=True)
    if not len(pairs):
        return labels
    order = np.lexsort((lengths, pairs[:, 1] > 0))  # for each area the last counts: blocks, then length
    goes_to = np.full(to_clean.size, -1, np.int32)
    goes_to[pairs[order, 0]] = pairs[order, 1]
    new = goes_to[areas]
    return np.where(new >= 0, new, labels).astype(np.int32)


# What an edit leaves behind.

_COVERED = 0.9
"""A block that loses more than this share of its pixels in one edit loses the rest beside them, too."""


def tidied(
    labels: Labels,
    patch: LabelPatch,
    smallest: int,
    *,
    known: Mask | None = None,
    smallest_block: float = 0,
    label: int = 0,
    locked: Collection[int] = (),
) -> LabelPatch | None:
    """Extend an edit by what it would leave behind: rests of blocks, blocks that cannot be completed, and slivers.

    Of a block that loses more than 90 % of its pixels, the rest beside the block that got most of them goes there, too.
    Changed blocks without known depth and of less than `smallest_block` pixels go to the neighbour with the longest
    border. Islands, slivers and holes that were none before are cleaned up as by `clean_up`, without the largest area
    that the edit has changed.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map before the edit.
    patch : LabelPatch
        The edit.
    smallest : int
        Minimum number of pixels of areas that stay.
    known : ndarray of bool, shape (H, W), optional
        Pixels with known depth; blocks without any stay if left out.
    smallest_block : float
    label : int
        The block that was painted or drawn, which stays as it is; 0 for none.
    locked : collection of int
        Blocks that must not change.

    Returns
    -------
    LabelPatch or None
        The whole edit, from `labels`; None if nothing is left of it.
    """
    after = labels.copy()
    patch.apply(after)
    changed = {int(one) for one in np.unique([patch.before, patch.after])} - {0, label, *locked}
    for one in changed:
        _join_rest(labels, after, one)
    box = bounds(after != labels)
    if box is None:
        return None
    crop, before = _cropped(labels, smallest, box)
    after[crop] = _without_new_slivers(before, after[crop], smallest, crop, labels.shape, locked)
    if known is not None:
        after = _without_useless(after, changed, known, smallest_block, locked)
    return patch_between(labels, after)


def _join_rest(before: Labels, after: Labels, label: int) -> None:
    """Give what is left of a block that was covered, in place, to the block that covers most of it."""
    block, rest = before == label, after == label
    if not 0 < np.count_nonzero(rest) < (1 - _COVERED) * np.count_nonzero(block):
        return
    taker = int(np.argmax(np.bincount(after[block & ~rest])))
    if taker:
        pieces = connected_regions(rest.astype(np.int32))
        after[have_border(pieces, after == taker)[pieces]] = taker


def _without_useless(
    labels: Labels, changed: Collection[int], known: Mask, smallest_block: float, locked: Collection[int]
) -> Labels:
    """Give changed blocks without known depth that are too small to their neighbours."""
    for _ in range(_PASSES):  # of two that are adjacent, one waits until the other is gone
        sizes = np.bincount(labels.ravel())
        useless = np.isin(np.arange(sizes.size), list(changed)) & (sizes < smallest_block)
        useless[labels[known]] = False
        if not useless[labels].any():
            break
        labels = given_to_neighbours(labels, np.where(useless[labels], labels, 0), useless, locked)
    return labels


def _without_new_slivers(
    before: Labels, after: Labels, smallest: int, crop: Box, shape: tuple[int, ...], locked: Collection[int]
) -> Labels:
    """Clean up a crop of the label map after an edit, but not what was to be cleaned up before it."""
    areas, to_clean = _areas_to_clean(before, smallest, crop, shape)
    old, edited = to_clean[areas], after
    for _ in range(_PASSES):
        areas, to_clean = _areas_to_clean(after, smallest, crop, shape)
        to_clean &= np.bincount(areas[~old], minlength=to_clean.size) > 0
        gained = np.bincount(areas[(edited != before) & (after == edited)], minlength=to_clean.size)
        to_clean[np.argmax(gained)] = False
        cleaned = given_to_neighbours(after, areas, to_clean, locked)
        if np.array_equal(cleaned, after):
            break
        after = cleaned
    return after


# Growing, shrinking and smoothing a block.


def grow(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Give a block all pixels within `px` pixels of it, except those of locked blocks."""

    def change(block: Mask, free: Mask) -> tuple[Mask, Mask]:
        return (_distance(block) <= px) & free, np.zeros_like(block)

    return _reshaped(labels, label, px, locked, change)


def shrink(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Remove all pixels within `px` pixels of a block's outline from it; its sides along the frame's rim stay.

    They go to the nearest adjacent block that is not locked, or to no block if none is that near. Along a locked block
    the outline stays. None if nothing of the block would be left.
    """

    def change(block: Mask, free: Mask) -> tuple[Mask, Mask]:
        return np.zeros_like(block), block & (_distance(~block & free) <= px)

    return _reshaped(labels, label, px, locked, change)


def smooth(labels: Labels, label: int, px: float, locked: Collection[int] = ()) -> LabelPatch | None:
    """Smooth a block's outline: details finer than about `px` pixels are removed, straight sections stay.

    A pixel belongs to the block if most of its surroundings do, weighted by a Gaussian of that standard deviation. The
    neighbours are adapted, except locked ones. None if nothing of the block would be left.
    """

    def change(block: Mask, free: Mask) -> tuple[Mask, Mask]:
        around = cv2.GaussianBlur(block.astype(np.float32), (0, 0), px, borderType=cv2.BORDER_REPLICATE)
        return ~block & free & (around > 0.5), block & (around < 0.5)

    return _reshaped(labels, label, 3 * px, locked, change)


def _reshaped(
    labels: Labels,
    label: int,
    px: float,
    locked: Collection[int],
    change: Callable[[Mask, Mask], tuple[Mask, Mask]],
) -> LabelPatch | None:
    """Change the outline of a block by up to `px` pixels: `change` returns what it gains and loses, given its pixels
    and the unlocked ones. Lost pixels go to the nearest block, or to none. None if nothing of it would be left."""
    box = None if label <= 0 or label in locked or px <= 0 else box_of(labels, label, rim=math.ceil(px) + 2)
    if box is None:
        return None
    before = labels[box]
    block, free = before == label, unlocked_pixels(before, locked)
    gained, lost = change(block, free)
    if not (block & ~lost).any():
        return None
    after, beside = before.copy(), ~block & free
    if lost.any() and beside.any():
        after[lost] = 0
        takers = beside & (before > 0)
        if takers.any():
            distance, (rows, columns) = distance_transform_edt(~takers, return_indices=True)
            near = lost & (distance <= px + 1.5)
            after[near] = before[rows[near], columns[near]]
    after[gained] = label
    return patch_within(box, before, after)


def _distance(mask: Mask) -> NDArray[np.float32]:
    """Distance [px] to the nearest pixel of a mask; infinite if there is none."""
    if not mask.any():
        return np.full(mask.shape, np.inf, np.float32)
    outside = (~mask).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(outside, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float32)


# Deleting and merging whole blocks.


def delete(labels: Labels, chosen: Collection[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Delete blocks: their pixels then belong to no block."""
    deleted = [label for label in chosen if label not in locked and label > 0]
    return patch_between(labels, np.where(np.isin(labels, deleted), 0, labels).astype(np.int32))


def merge(labels: Labels, chosen: Sequence[int], locked: Collection[int] = ()) -> LabelPatch | None:
    """Merge blocks under the first label of `chosen`, without locked blocks."""
    free = [label for label in chosen if label not in locked and label > 0]
    if len(free) < 2:
        return None
    return patch_between(labels, np.where(np.isin(labels, free), free[0], labels).astype(np.int32))


def parts_touch(labels: Labels, chosen: Collection[int]) -> bool:
    """Whether the pixels of some blocks are one 4-connected region, as a merged block should be."""
    together = np.isin(labels, [label for label in chosen if label > 0])
    box = bounds(together)
    return box is None or cv2.connectedComponents(together[box].astype(np.uint8), connectivity=4)[0] <= 2


def pixels_apart(labels: Labels, patch: LabelPatch | None, label: int) -> int:
    """Number of pixels given to a block by a change that have no border with its present pixels.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        The label map before the change.
    patch : LabelPatch or None
        The change; None for none.
    label : int
        The block; 0 is returned for a block without pixels.
    """
    if patch is None or not (labels == label).any():
        return 0
    gained = np.zeros(labels.shape, np.uint8)
    gained[patch.box] = (patch.before != label) & (patch.after == label)
    box = grown(patch.box, 1, labels.shape)
    areas = cv2.connectedComponents(gained[box], connectivity=4)[1].astype(np.int32)
    apart = ~have_border(areas, labels[box] == label)
    apart[0] = False
    return int(np.count_nonzero(apart[areas]))
