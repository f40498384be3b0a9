"""What a press takes hold of: points and lines within reach of the pointer."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gui.tools.base import Point
from gui.views.pointer import PointerEvent

REACH = 8.0
"""How far from the pointer things may be to be taken hold of, in pixels of the screen."""


def nearest(points: Sequence[Point], event: PointerEvent) -> int | None:
    """Which of some points is the nearest within reach; None if none is."""
    distances = [math.dist(point, (event.x, event.y)) for point in points]
    closest = min(range(len(points)), key=distances.__getitem__, default=None)
    return closest if closest is not None and distances[closest] <= REACH * event.pixel else None


def touches(start: Point, end: Point, event: PointerEvent) -> bool:
    """Whether the straight line between two points is within reach."""
    return off_line((event.x, event.y), start, end) <= REACH * event.pixel


def off_line(point: Point, start: Point, end: Point) -> float:
    """Distance of a point from the straight line between two others."""
    share = share_along(point, start, end)
    return math.dist(point, (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])))


def share_along(point: Point, start: Point, end: Point) -> float:
    """How far along the line between two others the nearest place to a point is, 0-1."""
    x, y = end[0] - start[0], end[1] - start[1]
    square = x * x + y * y
    if square == 0:
        return 0.0
    return min(max(((point[0] - start[0]) * x + (point[1] - start[1]) * y) / square, 0.0), 1.0)


def clamped(point: Point, shape: tuple[int, int]) -> Point:
    """The nearest pixel's centre on a frame of shape (H, W)."""
    height, width = shape
    x, y = (min(max(math.floor(value), 0), size - 1) + 0.5 for value, size in zip(point, (width, height), strict=True))
    return x, y
