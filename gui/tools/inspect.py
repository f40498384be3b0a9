"""Points to measure between."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from ilf.data.blocks import Box

from ..state.inspection import Inspection, Line
from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Press, Tool, line_path
from .line import REACH, clamped, nearest, straightened, touches


class MeasureTool(Tool):
    """Every click adds a point to the measurement under way; a point that is dragged moves."""

    points_only = True

    def __init__(self) -> None:
        self._press: Press | None = None
        self._held: tuple[int, int] | None = None
        self._before: Point = 0.0, 0.0
        self._under_way = False

    @property
    def hint(self) -> str:
        """What a click would do."""
        if self._under_way:
            return "Click: the next point | Backspace: take back | Enter or double-click: done"
        return "Click: measure from here | drag a point: move it"

    @property
    def busy(self) -> bool:
        """Whether a measurement is under way."""
        return self._under_way or self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Add a point by a click, move one by a drag, show how the measurement would go on."""
        measurements, at = host.inspection.measurements, clamped((event.x, event.y), host.session.frame.shape)
        if event.kind is PointerKind.PRESS:
            self._press, self._held = Press(event), _held(host, event)
            if self._held is not None:
                self._before = measurements.chains[self._held[0]][self._held[1]]
        elif event.kind is PointerKind.MOVE and self._press is not None:
            if self._press.follow(event) and self._held is not None:
                measurements.move_point(*self._held, at)
        elif event.kind is PointerKind.RELEASE and self._press is not None:
            press, self._press = self._press, None
            if self._held is None or not press.drags:
                measurements.add_point(*at)
        elif event.kind is PointerKind.DOUBLE:
            self.finish(host)
        self._under_way = measurements.is_open
        shows = self._under_way and event.kind is PointerKind.HOVER
        host.show_preview(Preview(line_path([measurements.chains[-1][-1], at]), dashed=True) if shows else None)
        return True

    def finish(self, host: Host) -> bool:
        """The measurement is whole."""
        return self.cancel(host)

    def cancel(self, host: Host) -> bool:
        """Put back a point that is being dragged, or end the measurement, which stays if it has more than one point."""
        measurements = host.inspection.measurements
        press, self._press = self._press, None
        host.show_preview(None)
        if press is not None and press.drags and self._held is not None:
            measurements.move_point(*self._held, self._before)
            return True
        self._under_way = False
        return measurements.end() or press is not None

    def take_back(self, host: Host) -> bool:
        """Drop the last point."""
        host.show_preview(None)
        done = host.inspection.measurements.take_back()
        self._under_way = host.inspection.measurements.is_open
        return done


def _held(host: Host, event: PointerEvent) -> tuple[int, int] | None:
    """Measurement and number of the point that a press takes hold of."""
    places = [(n, m) for n, chain in enumerate(host.inspection.measurements.chains) for m in range(len(chain))]
    points = [point for chain in host.inspection.measurements.chains for point in chain]
    found = nearest(points, event)
    return None if found is None else places[found]


# What tools have in common whose drag draws one shape over the picture, or changes the one that is there.

Shape = TypeVar("Shape")
Grip = TypeVar("Grip")


class DraggedTool(Tool, Generic[Shape, Grip]):
    """A drag draws the shape anew, or from where the press takes hold of it, changes it; there is one per frame."""

    def __init__(self) -> None:
        self._press: Press | None = None
        self._before: Shape | None = None
        self._grip: Grip | None = None
        """What the press has taken hold of; None to draw anew."""

    def shape(self, inspection: Inspection) -> Shape | None:
        """The present shape."""
        raise NotImplementedError

    def put(self, inspection: Inspection, shape: Shape | None) -> None:
        """Have another shape, or none."""
        raise NotImplementedError

    def grip(self, shape: Shape, event: PointerEvent) -> Grip | None:
        """What a press takes hold of; None for nothing."""
        raise NotImplementedError

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Shape:
        """The shape that a drag has come to, on a frame of shape (H, W)."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether the shape is being dragged."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw or change the shape while the button is down."""
        if event.kind is PointerKind.PRESS:
            self._press, self._before = Press(event), self.shape(host.inspection)
            self._grip = None if self._before is None else self.grip(self._before, event)
        elif event.kind in (PointerKind.MOVE, PointerKind.RELEASE) and self._press is not None:
            if self._press.follow(event):
                self.put(host.inspection, self.dragged(self._press, event, host.session.frame.shape))
            if event.kind is PointerKind.RELEASE:
                self._press = None
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the shape back as it was."""
        under_way, self._press = self.busy, None
        if under_way:
            self.put(host.inspection, self._before)
        return under_way

    def remove(self, host: Host) -> bool:
        """Remove the shape."""
        there = self.shape(host.inspection) is not None
        self.put(host.inspection, None)
        return there


# The line along which depth is plotted.


class ProfileTool(DraggedTool[Line, str]):
    """A drag draws the line; dragged by an end or in between, it is moved. Its ends are centres of pixels."""

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: a line to plot depth along | drag an end or the line: move it | Shift: straight | Esc: remove it"

    def shape(self, inspection: Inspection) -> Line | None:
        """The present line."""
        return inspection.line

    def put(self, inspection: Inspection, shape: Line | None) -> None:
        """Have another line, or none."""
        inspection.set_line(shape)

    def grip(self, shape: Line, event: PointerEvent) -> str | None:
        """Which end a press takes hold of, or the whole line."""
        end = nearest(shape, event)
        if end is not None:
            return ("start", "end")[end]
        return "whole" if touches(*shape, event) else None

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Line:
        """The line that a drag has come to."""
        at = event.x, event.y
        if self._before is None or self._grip is None:
            start = clamped(press.point, frame)
            return start, _end(start, at, event, frame)
        start, end = self._before
        if self._grip == "start":
            return _end(end, at, event, frame), end
        if self._grip == "end":
            return start, _end(start, at, event, frame)
        return _shifted(self._before, (at[0] - press.point[0], at[1] - press.point[1]), frame)


def _end(other: Point, at: Point, event: PointerEvent, shape: tuple[int, int]) -> Point:
    return clamped(straightened(other, at) if event.shift else at, shape)


def _shifted(line: Line, by: Point, shape: tuple[int, int]) -> Line:
    """The line moved by whole pixels, as far as it stays on the frame."""
    moves = []
    for axis, size in ((0, shape[1]), (1, shape[0])):
        low, high = sorted(point[axis] for point in line)
        moves.append(min(max(round(by[axis]), 0.5 - low), size - 0.5 - high))
    start, end = ((x + moves[0], y + moves[1]) for x, y in line)
    return start, end


# The rectangle that statistics and errors are told of.


@dataclass(frozen=True)
class _Sides:
    left: float
    top: float
    right: float
    bottom: float


class RectangleTool(DraggedTool[Box, frozenset[str]]):
    """A drag draws the rectangle; dragged by a side or a corner it is resized, from inside it is moved."""

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: a rectangle to take statistics of | drag its sides or inside: change it | Esc: remove it"

    def shape(self, inspection: Inspection) -> Box | None:
        """The present rectangle."""
        return inspection.region

    def put(self, inspection: Inspection, shape: Box | None) -> None:
        """Have another rectangle, or none."""
        inspection.set_region(shape)

    def grip(self, shape: Box, event: PointerEvent) -> frozenset[str] | None:
        """The sides that a press takes hold of: all of them from inside, none from outside."""
        return _grip(_sides(shape), event)

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Box:
        """The rectangle that a drag has come to."""
        x, y = press.point
        if self._before is None or not self._grip:
            # whatever pixels the drag has touched
            left, right = sorted((x, event.x))
            top, bottom = sorted((y, event.y))
            return _on_frame(_Sides(math.floor(left), math.floor(top), math.ceil(right), math.ceil(bottom)), frame)
        sides, by = _sides(self._before), {"x": event.x - x, "y": event.y - y}
        if self._grip == _ALL:
            by["x"] = min(max(round(by["x"]), -sides.left), frame[1] - sides.right)
            by["y"] = min(max(round(by["y"]), -sides.top), frame[0] - sides.bottom)
        moved = {side: round(getattr(sides, side) + by[_ALONG[side]]) for side in self._grip}
        return _on_frame(replace(sides, **moved), frame)


_ALONG = {"left": "x", "top": "y", "right": "x", "bottom": "y"}
_ALL = frozenset(_ALONG)


def _grip(sides: _Sides, event: PointerEvent) -> frozenset[str]:
    """The sides that a press takes hold of: all of them from inside, none from outside."""
    reach = REACH * event.pixel
    across = sides.left - reach <= event.x <= sides.right + reach
    down = sides.top - reach <= event.y <= sides.bottom + reach
    if not (across and down):
        return frozenset()
    taken = set()
    for at, (low, high) in ((event.x, ("left", "right")), (event.y, ("top", "bottom"))):
        start, stop = getattr(sides, low), getattr(sides, high)
        inside = min(reach, (stop - start) / 4)  # a small rectangle has an inside, too
        if at < start + inside:
            taken.add(low)
        elif at > stop - inside:
            taken.add(high)
    return frozenset(taken) or _ALL


def _sides(box: Box) -> _Sides:
    rows, columns = box
    return _Sides(columns.start, rows.start, columns.stop, rows.stop)


def _on_frame(sides: _Sides, shape: tuple[int, int]) -> Box:
    """The box between sides, whichever is where; of at least one pixel, on a frame of shape (H, W)."""
    spans = []
    for one, other, size in ((sides.top, sides.bottom, shape[0]), (sides.left, sides.right, shape[1])):
        low, high = sorted((int(one), int(other)))
        low = min(max(low, 0), size - 1)
        spans.append(slice(low, min(max(high, low + 1), size)))
    rows, columns = spans
    return rows, columns
