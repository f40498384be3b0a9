"""What the tools share that draw a line: freely in a drag, or from click to click."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..views.interaction import PointerEvent, Preview
from .base import Host, Point, Press, Tool, line_path, snapped
from .outlook import Outlook

# A line that is being drawn: freely, straight, or from click to click.

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


# What a press takes hold of: points and lines within reach of the pointer.

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


class LineTool(Tool):
    """A line under way. It snaps as far as the leash allows; with Shift it is straight."""

    options = ("leash",)

    def __init__(self) -> None:
        self._pen = Pen()
        self._press: Press | None = None
        self._by_clicks = False
        self._pixel = 1.0
        self._shown: list[Point] = []
        self._outlook: Outlook | None = None
        """What is known to come of the line, or of how it was a moment ago."""

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], Any] | None:
        """What finds out, off the GUI's thread, what would come of a line; None if nothing can be told."""
        return None

    def outlook(self, answer: Any, host: Host) -> Outlook:
        """What has been found out by what `look_ahead` gave."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether there is a line, or the button is down."""
        return self._press is not None or self._pen.down

    def cancel(self, host: Host) -> bool:
        """Drop the line."""
        under_way, self._press, self._by_clicks = self.busy, None, False
        self._pen.lift()
        self._outlook = None
        host.show_preview(None)
        return under_way

    def take_back(self, host: Host) -> bool:
        """Drop what the last click has added."""
        if not self._by_clicks:
            return False
        self._pen.take_back()
        if self._pen.down:
            self._show(host)
        else:
            self.cancel(host)
        return True

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Draw on while the button is down; False as long as this may yet be a click."""
        dragged = press.drags
        if not press.follow(event):
            return False
        self._pixel = event.pixel
        snap = self._snap(host)
        if not self._pen.down:
            self._pen.begin(press.point)
        elif not dragged:
            self._pen.go(press.point, event.shift, snap)
        self._pen.drag((event.x, event.y), event.shift, snap)
        self._show(host)
        return True

    def _click(self, point: Point, straight: bool, host: Host) -> None:
        """Go on to a point, or begin there."""
        self._by_clicks = True
        if self._pen.down:
            self._pen.go(point, straight, self._snap(host))
        else:
            self._pen.begin(point)
        self._show(host)

    def _show(self, host: Host, event: PointerEvent | None = None) -> None:
        """Show the line, and from click to click how it would go on to the pointer."""
        line = self._pen.line
        if event is not None:
            self._pixel = event.pixel
            line = line + self._pen.reach((event.x, event.y), event.shift, self._snap(host))[1:]
        self._shown = line
        self._draw(host)
        find = self.look_ahead(line, host) if len(line) > 1 else None
        if find is not None:
            host.work_out(find, partial(self._take_outlook, host))

    def _take_outlook(self, host: Host, answer: Any) -> None:
        if self._pen.down:
            self._outlook = self.outlook(answer, host)
            self._draw(host)

    def _draw(self, host: Host) -> None:
        corners = self._pen.corners if self._by_clicks else self._shown[:1]
        path = None if self._outlook is None else self._outlook.path
        host.show_preview(Preview(line_path(self._shown), corners, outlook=path))

    @property
    def _near(self) -> float:
        """How far a line may miss what it is drawn to, in pixels of the image."""
        return REACH * self._pixel

    def _snap(self, host: Host) -> Snap:
        """How a stretch is moved onto edges, as near as the view is now."""
        return partial(snapped, host, self._pixel)
