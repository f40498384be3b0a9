"""Flagged places that the user ignores, as long as blocks and known depth around them stay as they are."""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from .places import Place

_SAME = 30.0
"""Maximum distance [px] at which an ignored place equals another one of the same kind and block."""

_AROUND = 24
"""Distance [px] from the centre of a place, along rows and columns, in which a change makes it another place."""


@dataclass(frozen=True)
class IgnoredPlace:
    """A flagged place that is not to be shown again; stored in projects.

    Attributes
    ----------
    kind : str
    labels : tuple of int
        Its blocks.
    point : tuple of float
        Its centre (x, y) in image coordinates.
    checksum : int
        CRC-32 of the blocks and of the known pixels around it.
    """

    kind: str
    labels: tuple[int, ...]
    point: tuple[float, float]
    checksum: int

    def is_at(self, place: Place) -> bool:
        """Whether a place is of the same kind, block and position."""
        alike = place.kind == self.kind and not set(place.labels).isdisjoint(self.labels)
        return alike and math.dist(place.point, self.point) < _SAME


def ignore(place: Place, frame: RGBDFrame, labels: NDArray[np.int32]) -> IgnoredPlace:
    """Note that a place of a frame with these blocks, int32 (H, W), is ignored."""
    return IgnoredPlace(place.kind, place.labels, place.point, _checksum(place.point, frame, labels))


def without_ignored(
    places: Sequence[Place], ignored: Sequence[IgnoredPlace], frame: RGBDFrame, labels: NDArray[np.int32]
) -> list[Place]:
    """The places that are not ignored, in their order.

    Parameters
    ----------
    places : sequence of Place
    ignored : sequence of IgnoredPlace
        Those around which blocks or known depth have changed since do not count.
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)

    Examples
    --------
    >>> frame = RGBDFrame(np.zeros((40, 60, 3), np.uint8), np.full((40, 60), 1.0))
    >>> labels = np.ones((40, 60), np.int32)
    >>> place = Place("jump", (slice(10, 20), slice(10, 20)), (1,), (15.5, 15.5), 3.0, "")
    >>> ignored = ignore(place, frame, labels)
    >>> without_ignored([place], [ignored], frame, labels)
    []
    >>> labels[12, 14] = 2
    >>> without_ignored([place], [ignored], frame, labels) == [place]
    True
    """
    valid = [one for one in ignored if one.checksum == _checksum(one.point, frame, labels)]
    return [place for place in places if not any(one.is_at(place) for one in valid)]


def _checksum(point: tuple[float, float], frame: RGBDFrame, labels: NDArray[np.int32]) -> int:
    column, row = (int(at) for at in point)
    around = tuple(slice(max(at - _AROUND, 0), max(at + _AROUND + 1, 0)) for at in (row, column))
    return zlib.crc32(np.packbits(frame.known[around]).tobytes(), zlib.crc32(labels[around].tobytes()))
