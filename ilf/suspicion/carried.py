"""Blocks that came from another frame, and need a look."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from .place import Place

_NO_REASON = "it came from another frame."


def carried_places(labels: NDArray[np.integer], reasons: Mapping[int, str]) -> list[Place]:
    """The blocks that need a look as places, the largest first; they come before all others, whose harm can be judged.

    Parameters
    ----------
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    reasons : mapping of int to str
        Block label -> why, a sentence; "" where that is not known. Blocks that are not there are left out.

    Examples
    --------
    >>> place = carried_places(np.array([[1, 1, 2]]), {2: "It is new.", 3: ""})[0]
    >>> place.kind, place.point, place.reason
    ('carried', (2.5, 0.5), 'Block 2 was carried here: it is new.')
    """
    places: list[tuple[int, Place]] = []
    for label, reason in reasons.items():
        inside = labels == label
        rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
        if rows.size:
            box = slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
            why = reason[:1].lower() + reason[1:] if reason else _NO_REASON
            text = f"Block {label} was carried here: {why}"
            size = int(np.count_nonzero(inside))
            places.append((size, Place("carried", box, (label,), _middle(inside, box), math.inf, text)))
    return [place for _, place in sorted(places, key=lambda one: -one[0])]


def _middle(inside: NDArray[np.bool_], box: tuple[slice, slice]) -> tuple[float, float]:
    """The centre of the pixel of a block that is nearest to its mean."""
    rows, columns = np.nonzero(inside[box])
    nearest = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
    return float(columns[nearest] + box[1].start + 0.5), float(rows[nearest] + box[0].start + 0.5)
