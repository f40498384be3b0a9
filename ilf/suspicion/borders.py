"""Borders between surfaces at different depths that lie where nothing in the picture asks for one."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ..edges.pairs import apart, sides
from .ground import Ground
from .groups import largest_groups
from .place import Place

_STRONG, _WEAK = 0.5, 0.25
"""Edge strength from which on a border may well be there, and below which it hardly is."""

_BESIDE = 2
"""An edge within so many pixels of a border is under it."""

_REACH = 24
"""How far [px] from a border that is off the right place may be."""

_BLAME = 0.3
"""How sure it is that a border without an edge is wrong: in missing depth, colours of two surfaces may be alike."""

_NOWHERE = 4
"""How far [px] a border is taken to be off if there is no edge in reach that it might belong to."""


def find_weak_borders(ground: Ground, strength: NDArray[np.float32]) -> Iterator[Place]:
    """Stretches of borders through missing depth, off any edge, between blocks whose depths differ there."""
    off, apart_by, one, other = _stretches(ground, strength)
    harm = _BLAME * off * apart_by
    pair = np.where(harm > 0, one * (int(other.max()) + 1) + other, 0)
    numbers = np.asarray(connected_regions(pair, background=0, connectivity=2), np.int32)
    totals = np.bincount(numbers.ravel(), harm.ravel(), minlength=int(numbers.max()) + 1)
    for group in largest_groups(numbers, totals, one):
        beyond = int(other[group.rows[0], group.columns[0]])
        difference = float(np.median(apart_by[group.rows, group.columns]))
        reason = (
            f"Block {group.label} and Block {beyond} are {difference:.2f} m apart, and meet where nothing in colour or "
            "depth parts them."
        )
        yield Place("border", group.box, (group.label, beyond), group.point, group.harm, reason)


def _stretches(
    ground: Ground, strength: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """At the pixels of weak borders: how far [px] they may be off, how far apart [m] their blocks are, and the lower
    and the higher label of these; 0 elsewhere."""
    square = np.ones((2 * _BESIDE + 1,) * 2, np.uint8)
    under = cv2.dilate(strength, square)
    weak = (under < _WEAK) & ~ground.relief.near
    edges = (strength >= _STRONG).astype(np.uint8)
    away = cv2.distanceTransform(1 - edges, cv2.DIST_L2, 5) if edges.any() else np.full(edges.shape, np.inf)
    share = cv2.blur(ground.missing.astype(np.float64), (_REACH + 1,) * 2)
    off = share * np.where(away <= _REACH, away, _NOWHERE)
    found, difference = np.zeros(weak.shape), np.zeros(weak.shape)
    lower, higher = np.zeros(weak.shape, np.int64), np.zeros(weak.shape, np.int64)
    for parted, labels, sources, weaknesses in zip(
        apart(ground.labels), sides(ground.labels), sides(ground.source), sides(weak), strict=True
    ):
        both = parted & (labels[0] > 0) & (labels[1] > 0) & weaknesses[0] & weaknesses[1]
        rows, columns = np.nonzero(both)
        by = ground.apart(sources[0][rows, columns], sources[1][rows, columns])
        better = by > difference[rows, columns]
        rows, columns = rows[better], columns[better]
        difference[rows, columns] = by[better]
        found[rows, columns] = off[rows, columns]
        lower[rows, columns] = np.minimum(*labels)[rows, columns]
        higher[rows, columns] = np.maximum(*labels)[rows, columns]
    return found, difference, lower, higher
