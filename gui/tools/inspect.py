"""Inspection tools: measurements, the profile line and the rectangle."""

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
    """The tool Measure. Every click adds a point to the open measurement; a drag moves a point."""

    points_only = True

    def __init__(self) -> None:
        self._press: Press | None = None
        self._held: tuple[int, int] | None = None
        self._before: Point = 0.0, 0.0
        self._is_open = False

    @property
    def hint(self) -> str:
        """Hint: what a click would do."""
        if self._is_open:
            return "Click: next point | Backspace: remove last | Enter or double-click: done"
        return "Click: measure from here | drag a point: move it"

    @property
    def busy(self) -> bool:
        """Whether a measurement is open."""
        return self._is_open or self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Add a point by a click, move one by a drag, preview the next segment."""
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
        self._is_open = measurements.is_open
        shows = self._is_open and event.kind is PointerKind.HOVER
        host.show_preview(Preview(line_path([measurements.chains[-1][-1], at]), dashed=True) if shows else None)
        return True

    def finish(self, host: Host) -> bool:
        """Close the measurement."""
        return self.cancel(host)

    def cancel(self, host: Host) -> bool:
        """Restore a dragged point, or close the measurement, which stays if it has more than one point."""
        measurements = host.inspection.measurements
        press, self._press = self._press, None
        host.show_preview(None)
        if press is not None and press.drags and self._held is not None:
            measurements.move_point(*self._held, self._before)
            return True
        self._is_open = False
        return measurements.end() or press is not None

    def undo_last(self, host: Host) -> bool:
        """Remove the last point."""
        host.show_preview(None)
        done = host.inspection.measurements.undo_last()
        self._is_open = host.inspection.measurements.is_open
        return done


def _held(host: Host, event: PointerEvent) -> tuple[int, int] | None:
    """Return the indices of measurement and point under a press; None for none."""
    places = [(n, m) for n, chain in enumerate(host.inspection.measurements.chains) for m in range(len(chain))]
    points = [point for chain in host.inspection.measurements.chains for point in chain]
    found = nearest(points, event)
    return None if found is None else places[found]


# Base of tools whose drag draws a shape over the image or changes the existing one.

Shape = TypeVar("Shape")
Grip = TypeVar("Grip")


class ShapeTool(Tool, Generic[Shape, Grip]):
    """A tool whose drag draws a new shape, or changes the existing one at the pressed handle; one shape per frame."""

    def __init__(self) -> None:
        self._press: Press | None = None
        self._before: Shape | None = None
        self._grip: Grip | None = None
        """The handle under the press; None to draw a new shape."""

    def shape(self, inspection: Inspection) -> Shape | None:
        """Return the current shape."""
        raise NotImplementedError

    def put(self, inspection: Inspection, shape: Shape | None) -> None:
        """Set or remove the shape."""
        raise NotImplementedError

    def grip(self, shape: Shape, event: PointerEvent) -> Grip | None:
        """Return the handle under a press; None for none."""
        raise NotImplementedError

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Shape:
        """Return the shape after a drag, on a frame of shape (H, W)."""
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
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> bool:
        """Restore the former shape."""
        pending_work, self._press = self.busy, None
        if pending_work:
            self.put(host.inspection, self._before)
        return pending_work

    def remove(self, host: Host) -> bool:
        """Remove the shape."""
        there = self.shape(host.inspection) is not None
        self.put(host.inspection, None)
        return there


# The line along which depth is plotted.


class ProfileTool(ShapeTool[Line, str]):
    """The tool Profile line. A drag draws the line, or moves an end or all of it. Its ends are pixel centres."""

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        return "Drag: line to plot depth along | drag an end or the line: move it | Shift: straight | Esc: remove it"

    def shape(self, inspection: Inspection) -> Line | None:
        """Return the current line."""
        return inspection.line

    def put(self, inspection: Inspection, shape: Line | None) -> None:
        """Set or remove the line."""
        inspection.set_line(shape)

    def grip(self, shape: Line, event: PointerEvent) -> str | None:
        """Return the part under a press: "start", "end" or "whole"; None for none."""
        end = nearest(shape, event)
        if end is not None:
            return ("start", "end")[end]
        return "whole" if touches(*shape, event) else None

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Line:
        """Return the line after a drag."""
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
    """Return the line moved by whole pixels, kept on the frame."""
    moves = []
    for axis, size in ((0, shape[1]), (1, shape[0])):
        low, high = sorted(point[axis] for point in line)
        moves.append(min(max(round(by[axis]), 0.5 - low), size - 0.5 - high))
    start, end = ((x + moves[0], y + moves[1]) for x, y in line)
    return start, end


# The rectangle for statistics and errors.


@dataclass(frozen=True)
class _Sides:
    left: float
    top: float
    right: float
    bottom: float


class RectangleTool(ShapeTool[Box, frozenset[str]]):
    """The tool Rectangle. A drag draws it; dragging a side or a corner resizes it, dragging its inside moves it."""

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        return "Drag: rectangle for statistics | drag its sides or inside: change it | Esc: remove it"

    def shape(self, inspection: Inspection) -> Box | None:
        """Return the current rectangle."""
        return inspection.region

    def put(self, inspection: Inspection, shape: Box | None) -> None:
        """Set or remove the rectangle."""
        inspection.set_region(shape)

    def grip(self, shape: Box, event: PointerEvent) -> frozenset[str] | None:
        """Return the sides under a press: all of them from inside, none from outside."""
        return _grip(_sides(shape), event)

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Box:
        """Return the rectangle after a drag."""
        x, y = press.point
        if self._before is None or not self._grip:
            # all pixels that the drag has touched
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
    """Return the sides under a press: all of them from inside, none from outside."""
    reach = REACH * event.pixel
    across = sides.left - reach <= event.x <= sides.right + reach
    down = sides.top - reach <= event.y <= sides.bottom + reach
    if not (across and down):
        return frozenset()
    taken = set()
    for at, (low, high) in ((event.x, ("left", "right")), (event.y, ("top", "bottom"))):
        start, stop = getattr(sides, low), getattr(sides, high)
        inside = min(reach, (stop - start) / 4)  # so that a small rectangle keeps an inside
        if at < start + inside:
            taken.add(low)
        elif at > stop - inside:
            taken.add(high)
    return frozenset(taken) or _ALL


def _sides(box: Box) -> _Sides:
    rows, columns = box
    return _Sides(columns.start, rows.start, columns.stop, rows.stop)


def _on_frame(sides: _Sides, shape: tuple[int, int]) -> Box:
    """Return the box between sides in any order, of at least one pixel, on a frame of shape (H, W)."""
    spans = []
    for one, other, size in ((sides.top, sides.bottom, shape[0]), (sides.left, sides.right, shape[1])):
        low, high = sorted((int(one), int(other)))
        low = min(max(low, 0), size - 1)
        spans.append(slice(low, min(max(high, low + 1), size)))
    rows, columns = spans
    return rows, columns
