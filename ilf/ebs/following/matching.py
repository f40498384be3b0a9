"""Blocks of another extraction, named after those that they lie on."""

from __future__ import annotations

import itertools
from collections.abc import Collection

import numpy as np

from .parts import Labels

_OVERLAP = 0.5
"""Share of a fresh block that must lie on a carried one to be it."""


def free_numbers(taken: Collection[int]) -> itertools.count[int]:
    """Numbers above all that are taken."""
    return itertools.count(max(taken, default=0) + 1)


def named_by_overlap(fresh: Labels, carried: Labels, taken: Collection[int]) -> tuple[Labels, frozenset[int]]:
    """Fresh blocks with the numbers of the carried blocks on which most of each lies, and which of them are new.

    Parameters
    ----------
    fresh : ndarray of int32, shape (H, W)
        Label map of the new frame's extraction.
    carried : ndarray of int32, shape (H, W)
        Labels that were carried there, 0 or less where none was. Each goes to one block: the one with most of it.
    taken : collection of int
        Numbers that no new block gets.
    """
    both = (fresh > 0) & (carried > 0)
    pairs, counts = np.unique(np.stack([fresh[both], carried[both]]), axis=1, return_counts=True)
    sizes = np.bincount(fresh.ravel())
    number_of = np.zeros(sizes.size, np.int32)
    given: set[int] = set()
    for place in np.argsort(-counts, kind="stable").tolist():
        block, label = pairs[:, place].tolist()
        if number_of[block] == 0 and label not in given and counts[place] >= _OVERLAP * sizes[block]:
            number_of[block] = label
            given.add(label)
    free = free_numbers(taken)
    new = [block for block in np.flatnonzero(sizes).tolist() if block > 0 and number_of[block] == 0]
    for block in new:
        number_of[block] = next(free)
    return number_of[fresh], frozenset(number_of[new].tolist())
