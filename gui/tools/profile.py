"""The line along which depth is plotted."""

from __future__ import annotations

from gui.state.inspection import Line
from gui.tools.base import Host, Point, Press, Tool
from gui.tools.grips import clamped, nearest, touches
from gui.tools.pen import straightened
from gui.views.pointer import PointerEvent, PointerKind


class ProfileTool(Tool):
    """A drag draws the line; dragged by an end or in between, it is moved. Its ends are centres of pixels."""

    def __init__(self) -> None:
        self._press: Press | None = None
        self._before: Line | None = None
        self._grip = "new"

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: a line to plot depth along | drag an end or the line: move it | Shift: straight | Esc: remove it"

    @property
    def busy(self) -> bool:
        """Whether the line is being dragged."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw or move the line while the button is down."""
        if event.kind is PointerKind.PRESS:
            self._press, self._before = Press(event), host.inspection.line
            self._grip = _grip(self._before, event)
        elif event.kind in (PointerKind.MOVE, PointerKind.RELEASE) and self._press is not None:
            if self._press.follow(event):
                host.inspection.set_line(self._line(self._press.point, event, host.session.frame.shape))
            if event.kind is PointerKind.RELEASE:
                self._press = None
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the line back where it was."""
        under_way, self._press = self.busy, None
        if under_way:
            host.inspection.set_line(self._before)
        return under_way

    def remove(self, host: Host) -> bool:
        """Remove the line."""
        there = host.inspection.line is not None
        host.inspection.set_line(None)
        return there

    def _line(self, pressed: Point, event: PointerEvent, shape: tuple[int, int]) -> Line:
        at = event.x, event.y
        if self._before is None or self._grip == "new":
            start = clamped(pressed, shape)
            return start, _end(start, at, event, shape)
        start, end = self._before
        if self._grip == "start":
            return _end(end, at, event, shape), end
        if self._grip == "end":
            return start, _end(start, at, event, shape)
        return _shifted(self._before, (at[0] - pressed[0], at[1] - pressed[1]), shape)


def _grip(line: Line | None, event: PointerEvent) -> str:
    """What a press takes hold of."""
    if line is None:
        return "new"
    end = nearest(line, event)
    if end is not None:
        return ("start", "end")[end]
    return "whole" if touches(*line, event) else "new"


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
