"""Extracting blocks again: which blocks are kept, and how new blocks fill the rest."""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..data.blocks import Blocks, labels_in
from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters
from ..data.pixel_grids import connected_regions
from .editing.cleaning import given_to_neighbours
from .extraction import found_blocks
from .merging import numbered

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
    free = itertools.filterfalse(frozenset(kept).__contains__, itertools.count(1))
    numbers = np.array([0, *itertools.islice(free, int(labels.max()))], np.int32)
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
    sizes = np.bincount(parts.ravel())
    origin = np.zeros(sizes.size, np.int32)
    origin[parts] = left
    slivers = (sizes < smallest) & np.isin(origin, np.unique(fresh[stays]))
    slivers[0] = False
    while True:  # slivers that touch only slivers are merged in a later round
        joined = given_to_neighbours(parts, parts, slivers, locked=[0])
        if np.array_equal(joined, parts):
            break
        parts = joined
    return overlay_kept(present, kept, numbered(np.where(slivers[parts], 0, parts)))


def gaps_filled(given: Blocks, frame: RGBDFrame, extraction: BlockParameters) -> Blocks:
    """Return given blocks of a frame with extracted ones in their gaps; slivers of these below the smallest size of a
    block are merged into a neighbouring new one."""
    found, smallest = found_blocks(frame, extraction), extraction.smallest_block(given.labels.size)
    labels = fill_around(given.labels, labels_in(given.labels), found.labels, smallest)
    return replace(found, labels=labels, infos=given.infos, extracted=None, notes=given.notes + found.notes)
