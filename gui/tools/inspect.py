"""Inspection tools: measurements, the profile line and the rectangle."""

from __future__ import annotations

import math
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box
from ilf.evaluation.measuring import Line, point_in_space

from ..state.document import Document
from ..state.parts import Part
from ..views.interaction import PointerEvent, Preview
from .base import Host, Point, Press, Tool, line_path
from .line import REACH, clamped, nearest, straightened, touches


class MeasureTool(Tool):
    """Measure distances, heights and angles between points.

    Two clicks make a measurement, and so does a drag beside the ends of others; a drag of an end moves it.
    """

    points_only = True

    def __init__(self) -> None:
        self._start: Point | None = None
        """The first point, until the second is clicked."""
        self._held: tuple[int, int] | None = None
        """The measurement and its end under the press."""
        self._before: tuple[Line, ...] = ()

    @property
    def hint(self) -> str:
        """Hint: what a click would do."""
        return "Click, or drag: measure | drag an end: move it" if self._start is None else "Click: measure to here"

    @property
    def busy(self) -> bool:
        """Whether a measurement is unfinished."""
        return self._start is not None or self._press is not None

    def _begin(self, event: PointerEvent, host: Host) -> bool:
        host.show_preview(None)
        self._before = host.document.state.looked.measurements
        found = None if self._start is not None else nearest([end for line in self._before for end in line], event)
        self._held = None if found is None else divmod(found, 2)
        return True

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Move an end, or draw a new measurement."""
        drags = press.follow(event)
        if drags and self._held is None:
            if self._start is None:
                self._press = None  # a refused start ends the drag
                self._click(clamped(press.point, host.document.frame.shape), host)
                self._press = press
            self._hover(event, host)
        elif drags and self._held is not None:
            number, end = self._held
            ends, moved = list(self._before[number]), list(self._before)
            ends[end] = clamped((event.x, event.y), host.document.frame.shape)
            moved[number] = (ends[0], ends[1])
            host.document.set_measurements(moved)
        return drags

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Take a point, that of a click or the second one of a drag."""
        host.show_preview(None)
        if self._held is None or not press.drags:
            self._click(clamped((event.x, event.y), host.document.frame.shape), host)

    def _hover(self, event: PointerEvent, host: Host) -> None:
        """Preview the line to the second point."""
        if self._start is not None:
            at = clamped((event.x, event.y), host.document.frame.shape)
            host.show_preview(Preview(line_path([self._start, at]), dashed=True))

    def _leave(self, host: Host) -> None:
        host.show_preview(None)

    def cancel(self, host: Host) -> None:
        """Restore a dragged end, or drop the first point."""
        press = self._press
        self._press = self._start = None
        host.show_preview(None)
        if press is not None and press.drags and self._held is not None:
            host.document.set_measurements(self._before)

    def undo_last(self, host: Host) -> bool:
        """Drop the first point."""
        was_busy = self.busy
        self.cancel(host)
        return was_busy

    def _click(self, at: Point, host: Host) -> None:
        frame, depth = host.document.frame, host.document.current_depth()
        point_in_space(frame.depth if depth is None else depth, at, frame.intrinsics)  # refused without a place
        if self._start is None:
            self._start = at
        else:
            host.document.set_measurements([*host.document.state.looked.measurements, (self._start, at)])
            self._start = None


# Base of tools whose drag draws a shape over the image or changes the existing one.

Shape = TypeVar("Shape")
Grip = TypeVar("Grip")


class ShapeTool(Tool, Generic[Shape, Grip]):
    """A tool whose drag draws a new shape, or changes the existing one at the pressed handle; one shape per frame.

    Attributes
    ----------
    name : str
        Its name in the frame's `looked`.
    part : Part
        What changes with it.
    """

    name: str
    part: Part

    def __init__(self) -> None:
        self._before: Shape | None = None
        self._grip: Grip | None = None
        """The handle under the press; None to draw a new shape."""

    def _shape(self, document: Document) -> Shape | None:
        shape: Shape | None = getattr(document.state.looked, self.name)
        return shape

    def _put(self, document: Document, shape: Shape | None) -> None:
        document.look(self.part, True, **{self.name: shape})

    def grip(self, shape: Shape, event: PointerEvent) -> Grip | None:
        """Return the handle under a press; None for none."""
        raise NotImplementedError

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Shape:
        """Return the shape after a drag, on a frame of shape (H, W)."""
        raise NotImplementedError

    def _begin(self, event: PointerEvent, host: Host) -> bool:
        self._before = self._shape(host.document)
        self._grip = None if self._before is None else self.grip(self._before, event)
        return True

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Draw or change the shape."""
        drags = press.follow(event)
        if drags:
            self._put(host.document, self.dragged(press, event, host.document.frame.shape))
        return drags

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        self._drag(press, event, host)

    def cancel(self, host: Host) -> None:
        """Restore the former shape."""
        if self.busy:
            self._press = None
            self._put(host.document, self._before)

    def remove(self, host: Host) -> bool:
        """Remove the shape."""
        there = self._shape(host.document) is not None
        self._put(host.document, None)
        return there


# The line along which depth is plotted.


class ProfileTool(ShapeTool[Line, str]):
    """Draw a line across the image and plot the depth along it.

    A drag draws the line, or moves an end or all of it. Its ends are pixel centres.
    """

    name, part = "line", Part.MARKS
    hint = "Drag: line to plot depth along | drag an end or the line: move it | Shift: straight | Esc: remove it"

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


Sides = NDArray[np.float64]
"""Numbers of the left, right, upper and lower side."""


class RectangleTool(ShapeTool[Box, Sides]):
    """Draw a rectangle for statistics and errors.

    Dragging a side or a corner resizes it, dragging its inside moves it.
    """

    name, part = "region", Part.REGION
    hint = "Drag: rectangle for statistics | drag its sides or inside: change it | Esc: remove it"

    def grip(self, shape: Box, event: PointerEvent) -> Sides | None:
        """Return 1 for the sides under a press, for all of them inside, else 0; None outside."""
        reach, taken = REACH * event.pixel, list[float]()
        for at, span in ((event.x, shape[1]), (event.y, shape[0])):
            if not span.start - reach <= at <= span.stop + reach:
                return None
            inside = min(reach, (span.stop - span.start) / 4)  # so that a small rectangle keeps an inside
            is_low = at < span.start + inside
            taken += [is_low, not is_low and at > span.stop - inside]
        return np.array(taken if any(taken) else [1] * 4, float)

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Box:
        """Return the rectangle after a drag."""
        (height, width), (x, y) = frame, press.point
        if self._before is None or self._grip is None:
            # all pixels that the drag has touched
            (left, right), (top, bottom) = sorted((x, event.x)), sorted((y, event.y))
            sides = np.array([math.floor(left), math.ceil(right), math.floor(top), math.ceil(bottom)])
        else:
            rows, columns = self._before
            dx, dy = event.x - x, event.y - y
            if self._grip.all():
                dx = min(max(round(dx), -columns.start), width - columns.stop)
                dy = min(max(round(dy), -rows.start), height - rows.stop)
            before = np.array([columns.start, columns.stop, rows.start, rows.stop])
            sides = np.round(before + self._grip * [dx, dx, dy, dy])
        return _span(sides[2:], height), _span(sides[:2], width)


def _span(sides: NDArray[Any], size: int) -> slice:
    """Return the pixels between two sides in any order, at least one, of `size` pixels."""
    low, high = (int(side) for side in np.sort(sides))
    low = min(max(low, 0), size - 1)
    return slice(low, min(max(high, low + 1), size))
