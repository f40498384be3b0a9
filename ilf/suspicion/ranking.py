"""All suspicious places of a frame, the worst first."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ..blocks import checked_labels
from ..errors import InputError
from ..frame import RGBDFrame
from ..stopping import check_stopped
from .borders import find_weak_borders
from .errors import find_high_errors
from .faults import find_faults
from .ground import survey
from .islands import find_islands
from .place import Place

LEAST_HARM = 1.0
"""Score below which a place is not worth looking at: ten pixels that are ten centimetres off."""

_SAME = 20.0
"""Places of one block that are closer [px] than this are one."""


def suspicious_places(
    frame: RGBDFrame,
    labels: NDArray[np.integer],
    strength: NDArray[np.float32],
    error: NDArray[np.float32] | None = None,
    *,
    least: float = LEAST_HARM,
) -> list[Place]:
    """Where the blocks of a frame, or its filled depth, look wrong; the most harmful places first.

    What counts is the depth that is to be filled: a border between two parts of one plane does no harm wherever it
    runs, and is none of them.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1], as by `ilf.edge_strength`.
    error : ndarray of float32, shape (H, W), optional
        Expected error [m] of filled depth, NaN where nothing was filled; without it, no place is there because of it.
    least : float
        Score that a place has at least.

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
    >>> for place in suspicious_places(frame, np.ones((40, 60), np.int32), np.zeros((40, 60), np.float32)):
    ...     print(place.kind, place.reason)
    jump Depth jumps by 0.50 m inside Block 1.
    """
    blocks = checked_labels(labels, frame.shape)
    for array, name in ((strength, "edge strength"), (error, "expected error")):
        if array is not None and array.shape != frame.shape:
            raise InputError(f"The {name} has shape {array.shape}, but the frame has {frame.shape}.")
    ground = survey(frame, blocks)
    found: list[Place] = []
    for find in (find_faults, find_weak_borders, find_islands):
        check_stopped()
        found += find(ground, strength)
    if error is not None:
        found += find_high_errors(ground, error)
    return _distinct(place for place in found if place.score >= least)


def _distinct(places: Iterable[Place]) -> list[Place]:
    """From the highest score down, without those that a higher one stands for."""
    kept: list[Place] = []
    for place in sorted(places, key=lambda place: (-place.score, place.point)):
        if not any(math.dist(place.point, other.point) < _SAME and {*place.labels} & {*other.labels} for other in kept):
            kept.append(place)
    return kept
