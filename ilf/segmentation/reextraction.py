"""Extracting blocks again: which blocks are kept, and how new blocks fill the rest. Functions of label maps."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from ..data.label_map import labels_in
from ..data.parameters import BlockParameters
from ..data.pixel_grids import connected_regions, sides

Labels = NDArray[np.int32]


def made_by_hand(present: Labels, extracted: Labels | None) -> frozenset[int]:
    """Blocks with pixels that the last extraction did not give them, or from which pixels were erased.

    A block that has only lost pixels to other blocks does not count: the others are made by hand.

    Parameters
    ----------
    present : ndarray of int32, shape (H, W)
        The label map, 0 = no block.
    extracted : ndarray of int32, shape (H, W), or None
        The label map of that extraction; None if there was none, so all blocks are made by hand.
    """
    if extracted is None:
        return labels_in(present)
    changed = present != extracted
    gained, erased = labels_in(present[changed]), labels_in(extracted[changed & (present == 0)])
    return gained | (erased & labels_in(present))


def overlay_kept(present: Labels, kept: Collection[int], labels: Labels) -> Labels:
    """Another label map with the kept blocks on top; its own blocks get other numbers than those."""
    if not kept:
        return labels
    numbers = np.array([0, *itertools.islice(_free_numbers(kept), int(labels.max()))], np.int32)
    return np.where(np.isin(present, list(kept)), present, numbers[labels])


def fill_around(present: Labels, kept: Collection[int], fresh: Labels, smallest: float) -> Labels:
    """The blocks of an extraction around the kept blocks.

    Parameters
    ----------
    present : ndarray of int32, shape (H, W)
        The current label map, 0 = no block.
    kept : collection of int
        Its blocks that do not change in any pixel; no other block gets their numbers.
    fresh : ndarray of int32, shape (H, W)
        Label map of the extraction.
    smallest : float
        Minimum number of pixels of a part that kept blocks cut off. A smaller one is merged into the new block with
        the longest border to it; if there is none, it belongs to no block.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Every new block is one 4-connected region; they are numbered in order of decreasing size. `fresh` itself if
        nothing is kept.
    """
    if not kept:
        return fresh
    stays = np.isin(present, list(kept))
    left = np.where(stays, 0, fresh)
    parts = connected_regions(left)
    count = int(parts.max()) + 1
    sizes = np.bincount(parts.ravel(), minlength=count)
    origin = np.zeros(count, np.int32)
    origin[parts] = left
    slivers = (sizes < smallest) & np.isin(origin, np.unique(fresh[stays]))
    slivers[0] = False
    groups = _join(slivers, *_borders(parts, count))
    sizes = np.bincount(groups, weights=sizes, minlength=count)
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")[: np.count_nonzero(sizes)]
    numbers = np.zeros(count, np.int32)
    numbers[order] = [*itertools.islice(_free_numbers(kept), len(order))]
    return np.where(stays, present, numbers[groups][parts])


def _free_numbers(taken: Collection[int]) -> itertools.filterfalse[int]:
    return itertools.filterfalse(frozenset(taken).__contains__, itertools.count(1))


def _borders(parts: NDArray[np.integer], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs of adjacent parts, (n, 2), the lower number first, and their border lengths in pixel pairs, (n,)."""
    found = []
    for one, other in sides(parts):
        across = (one != other) & (one > 0) & (other > 0)
        pair = one[across].astype(np.int64), other[across].astype(np.int64)
        found.append(np.minimum(*pair) * count + np.maximum(*pair))
    pairs, lengths = np.unique(np.concatenate(found), return_counts=True)
    return np.column_stack((pairs // count, pairs % count)), lengths


def _join(slivers: NDArray[np.bool_], pairs: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.intp]:
    """Part -> the part that it is merged into: itself, a neighbour if it is a sliver, 0 if there is none."""
    neighbours: dict[int, dict[int, int]] = {int(sliver): {} for sliver in np.flatnonzero(slivers)}
    for (one, other), length in zip(pairs.tolist(), lengths.tolist(), strict=True):
        for part, neighbour in ((one, other), (other, one)):
            if part in neighbours:
                neighbours[part][neighbour] = length
    groups = np.arange(slivers.size)
    while True:
        # slivers that touch only slivers are merged in a later round
        homes = {sliver: _longest_border(around, neighbours, groups) for sliver, around in neighbours.items()}
        found = {sliver: home for sliver, home in homes.items() if home}
        if not found:
            groups[[*neighbours]] = 0
            return groups
        for sliver, home in found.items():
            groups[sliver] = home
            del neighbours[sliver]


def _longest_border(around: dict[int, int], unassigned: Collection[int], groups: NDArray[np.intp]) -> int:
    """The group with the longest share of a border; 0 if all its neighbours are parts without a group."""
    lengths: Counter[int] = Counter()
    for part, length in around.items():
        if part not in unassigned:
            lengths[int(groups[part])] += length
    return max(lengths, key=lengths.__getitem__, default=0)


# Filling the gaps of label maps that do not cover the frame, such as those of other programs.


def with_gaps_filled(
    labels: NDArray[np.int32], extracted: NDArray[np.int32], parameters: BlockParameters
) -> NDArray[np.int32]:
    """A label map whose gaps are filled with the blocks of an extraction.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block; its blocks and their numbers do not change.
    extracted : ndarray of int32, shape (H, W)
        Blocks of an extraction.
    parameters : BlockParameters
        Parameters of the extraction: slivers below its minimum block size are merged into a neighbouring new block.

    Returns
    -------
    ndarray of int32, shape (H, W)
    """
    return fill_around(labels, labels_in(labels), extracted, parameters.smallest_block(labels.size))
