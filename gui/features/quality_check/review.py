"""The flagged places of one frame, and which one is shown. No widgets."""

from __future__ import annotations

from collections.abc import Sequence

from ilf.evaluation.quality.places import Place

_ROOM = 10
"""Margin [px] around the box of the former place in which a place counts as the same: an edit may move it."""


class Review:
    """Flagged places of one frame, the worst first, and the current one."""

    def __init__(self) -> None:
        self.places: Sequence[Place] = ()
        self.present: Place | None = None
        """The current place; None before the first one, and after it has been fixed."""
        self._next = 0

    @property
    def number(self) -> int:
        """Number of the current place, from 1; 0 for none."""
        return 0 if self.present is None else self.places.index(self.present) + 1

    def take(self, found: Sequence[Place]) -> bool:
        """Set the places found after a change; return True if the current place is gone."""
        former, self.places = self.present, found
        if former is None:
            return False
        self._next = sum(place.score > former.score for place in self.places)
        self.present = next((place for place in self.places if _is_part(place, former)), None)
        return self.present is None

    def step(self, by: int) -> Place | None:
        """Move to the next place, or to the previous one with -1, cyclically; return it, None if there is none."""
        if not self.places:
            self.present = None
            return None
        if self.present is None:
            position = self._next if by > 0 else self._next - 1
        else:
            position = self.places.index(self.present) + by
        self.present = self.places[position % len(self.places)]
        return self.present


def _is_part(place: Place, whole: Place) -> bool:
    rows, columns = whole.box
    inside = (
        columns.start - _ROOM <= place.point[0] < columns.stop + _ROOM
        and rows.start - _ROOM <= place.point[1] < rows.stop + _ROOM
    )
    return inside and place.kind == whole.kind and bool(set(place.labels) & set(whole.labels))
