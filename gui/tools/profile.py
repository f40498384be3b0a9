"""The line along which depth is plotted."""

from __future__ import annotations

from gui.state.inspection import Inspection, Line
from gui.tools.base import Point, Press
from gui.tools.dragged import DraggedTool
from gui.tools.grips import clamped, nearest, touches
from gui.tools.pen import straightened
from gui.views.pointer import PointerEvent


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
