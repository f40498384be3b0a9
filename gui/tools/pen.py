"""A line that is being drawn: freely, straight, or from click to click."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from gui.tools.base import Point

Snap = Callable[[list[Point]], list[Point]]
"""Moves a drawn line onto the edges nearby."""

_MAGNET = math.radians(4)
"""How near to upright, level or diagonal a straight line becomes just that."""

_STEP = 0.5
"""Pixels that a freely drawn line goes before it has another point."""


@dataclass
class _Stretch:
    drawn: list[Point]
    line: list[Point]
    straight: bool


class Pen:
    """A line in stretches: each free, and moved onto edges nearby, or straight, and left as drawn."""

    def __init__(self) -> None:
        self._start: Point | None = None
        self._stretches: list[_Stretch] = []
        self._open = False

    @property
    def down(self) -> bool:
        """Whether there is a line."""
        return self._start is not None

    @property
    def line(self) -> list[Point]:
        """The line as it lies."""
        points = self._first
        for stretch in self._stretches:
            points += stretch.line[1:]
        return points

    @property
    def corners(self) -> list[Point]:
        """Where the line begins, and where its stretches end."""
        return self._first + [stretch.line[-1] for stretch in self._stretches]

    @property
    def _first(self) -> list[Point]:
        if self._start is None:
            return []
        return self._stretches[0].line[:1] if self._stretches else [self._start]

    def lift(self) -> None:
        """Drop the line."""
        self._start = None
        self._stretches = []
        self._open = False

    def begin(self, point: Point) -> None:
        """Begin a line."""
        self.lift()
        self._start = point

    def drag(self, point: Point, straight: bool, snap: Snap) -> None:
        """Draw on to a point; a stretch goes on for as long as it is drawn in the same way."""
        if not self._open or self._stretches[-1].straight != straight:
            end = self.corners[-1]
            self._stretches.append(_Stretch([end], [end], straight))
            self._open = True
        stretch = self._stretches[-1]
        if straight:
            stretch.drawn = stretch.line = [stretch.drawn[0], straightened(stretch.drawn[0], point)]
        elif len(stretch.drawn) == 1 or math.dist(stretch.drawn[-1], point) >= _STEP:
            stretch.drawn.append(point)
            stretch.line = snap(stretch.drawn)

    def rest(self) -> None:
        """What is drawn next is another stretch."""
        self._open = False

    def go(self, point: Point, straight: bool, snap: Snap) -> None:
        """One stretch to a point, as by a click."""
        self.rest()
        self.drag(point, straight, snap)
        self.rest()

    def reach(self, point: Point, straight: bool, snap: Snap) -> list[Point]:
        """The stretch that `go` would add."""
        end = self.corners[-1]
        return [end, straightened(end, point)] if straight else snap([end, point])

    def take_back(self) -> None:
        """Drop the last stretch, or the start if there is no other."""
        self._open = False
        if self._stretches:
            self._stretches.pop()
        else:
            self._start = None


def straightened(start: Point, end: Point) -> Point:
    """The end of a straight line, turned upright, level or diagonal if it is nearly so."""
    along, down = end[0] - start[0], end[1] - start[1]
    angle = math.atan2(down, along)
    nearest = round(angle / (math.pi / 4)) * math.pi / 4
    if abs(angle - nearest) > _MAGNET:
        return end
    length = math.hypot(along, down) * math.cos(angle - nearest)
    return start[0] + length * math.cos(nearest), start[1] + length * math.sin(nearest)
