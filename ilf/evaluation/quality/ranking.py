"""The quality checks of a frame, by score."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from ..._runtime.cancellation import check_cancelled
from ...data.arrays import check_shape
from ...data.frame import RGBDFrame
from ...data.label_map import checked_labels, find_blocks
from .checks import find_high_errors, find_islands, find_multiple_surfaces, find_weak_borders
from .places import Group, Place, make_check_input

MIN_SCORE = 1.0
"""Minimum score of a place to check: ten pixels with an error of ten centimetres."""

_MERGE_DISTANCE = 20.0
"""Places of one block that are closer [px] than this are merged."""


def find_places(
    frame: RGBDFrame,
    labels: NDArray[np.integer],
    strength: NDArray[np.float32],
    error: NDArray[np.float32] | None = None,
    *,
    least: float = MIN_SCORE,
) -> list[Place]:
    """Find places where the blocks of a frame, or its filled depth, look wrong; highest scores first.

    The score is the effect on the depth to be filled: a border between two parts of one plane has none and is not
    flagged.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1], from `ilf.edge_strength`.
    error : ndarray of float32, shape (H, W), optional
        Expected error [m] of filled depth, NaN where nothing was filled; not checked if left out.
    least : float
        Minimum score of a place.

    Returns
    -------
    list of Place

    Raises
    ------
    InputError
        If shapes do not fit.

    Examples
    --------
    >>> depth = np.full((40, 60), 1.0)
    >>> depth[:, 30:] = 1.5
    >>> depth[10:30, 26:34] = np.nan
    >>> frame = RGBDFrame(np.zeros((40, 60, 3), np.uint8), depth)
    >>> for place in find_places(frame, np.ones((40, 60), np.int32), np.zeros((40, 60), np.float32)):
    ...     print(place.kind, place.reason)
    jump Depth jumps by 0.50 m inside Block 1.
    """
    blocks = checked_labels(labels, frame.shape)
    for array, name in ((strength, "edge strength"), (error, "expected error")):
        if array is not None:
            check_shape(f"The {name}", array.shape, frame.shape)
    inputs = make_check_input(frame, blocks)
    found: list[Place] = []
    for find in (find_multiple_surfaces, find_weak_borders, find_islands):
        check_cancelled()
        found += find(inputs, strength)
    if error is not None:
        found += find_high_errors(inputs, error)
    return _distinct(place for place in found if place.score >= least)


def _distinct(places: Iterable[Place]) -> list[Place]:
    """Places by decreasing score, without those merged into one with a higher score."""
    kept: list[Place] = []
    for place in sorted(places, key=lambda place: (-place.score, place.point)):
        if not any(
            math.dist(place.point, other.point) < _MERGE_DISTANCE and {*place.labels} & {*other.labels}
            for other in kept
        ):
            kept.append(place)
    return kept


# Blocks that were propagated from another frame and need a check.

_NO_REASON = "it came from another frame."


def propagated_places(labels: NDArray[np.int32], reasons: Mapping[int, str]) -> list[Place]:
    """The propagated blocks to check as places, the largest first; they come before all others.

    Parameters
    ----------
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    reasons : mapping of int to str
        Block label -> reason, a sentence; "" if unknown. Labels without a block are left out.

    Examples
    --------
    >>> place = propagated_places(np.array([[1, 1, 2]]), {2: "It is new.", 3: ""})[0]
    >>> place.kind, place.point, place.reason
    ('propagated', (2.5, 0.5), 'Block 2 was propagated: it is new.')
    """
    blocks = find_blocks(labels, list(reasons)).values()
    places = []
    for block in sorted(blocks, key=lambda block: -np.count_nonzero(block.mask)):
        reason = reasons[block.label]
        why = reason[:1].lower() + reason[1:] if reason else _NO_REASON
        text = f"Block {block.label} was propagated: {why}"
        group = Group.of(block.label, block.box, block.mask, math.inf)
        places.append(Place("propagated", block.box, (block.label,), group.point, group.harm, text))
    return places
