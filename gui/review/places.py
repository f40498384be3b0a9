"""Going through suspicious places: which one is looked at, which were left as they are. No widgets."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ilf.suspicion import Place

_SAME = 30.0
"""A place that was left is the same as another one of its kind and block so near [px]."""

_ROOM = 10
"""A place is the one that was looked at if it is in its box, give or take so many pixels: an edit may move it."""


class Review:
    """The places of one frame, the worst first, and the one that is looked at."""

    def __init__(self) -> None:
        self.places: Sequence[Place] = ()
        self.present: Place | None = None
        """What is looked at; None before the first, and when it has been mended."""
        self._left: list[Place] = []
        self._next = 0

    @property
    def left(self) -> int:
        """How many places were left as they are."""
        return len(self._left)

    @property
    def number(self) -> int:
        """Which one of the places is looked at, from 1 on; 0 for none."""
        return 0 if self.present is None else self.places.index(self.present) + 1

    def take(self, found: Sequence[Place]) -> bool:
        """Take what is found now that something has changed; True if what was looked at is there no more."""
        former = self.present
        self.places = [place for place in found if not any(_is_same(place, one) for one in self._left)]
        if former is None:
            return False
        self._next = self._worse_than(former)
        self.present = next((place for place in self.places if _is_part(place, former)), None)
        return self.present is None

    def _worse_than(self, former: Place) -> int:
        """How many places are worse than one that may be gone."""
        return sum(place.score > former.score for place in self.places)

    def step(self, by: int) -> Place | None:
        """Look at the next place, or at the one before with -1, round and round; None if there is none."""
        if not self.places:
            self.present = None
            return None
        if self.present is None:
            position = self._next if by > 0 else self._next - 1
        else:
            position = self.places.index(self.present) + by
        self.present = self.places[position % len(self.places)]
        return self.present

    def leave(self) -> Place | None:
        """Pass over what is looked at, for good, and look at the next; None if that is all."""
        if self.present is None:
            return self.step(1)
        self._left.append(self.present)
        self._next = self.number - 1
        self.places = [place for place in self.places if place is not self.present]
        self.present = None
        return self.step(1)


def _is_same(place: Place, other: Place) -> bool:
    alike = place.kind == other.kind and set(place.labels) & set(other.labels)
    return bool(alike) and math.dist(place.point, other.point) < _SAME


def _is_part(place: Place, whole: Place) -> bool:
    rows, columns = whole.box
    inside = (
        columns.start - _ROOM <= place.point[0] < columns.stop + _ROOM
        and rows.start - _ROOM <= place.point[1] < rows.stop + _ROOM
    )
    return inside and place.kind == whole.kind and bool(set(place.labels) & set(whole.labels))
