"""The rectangle that statistics and errors are told of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gui.tools.base import Host, Press, Tool
from gui.tools.grips import REACH
from gui.views.pointer import PointerEvent, PointerKind
from ilf.blocks import Box


@dataclass(frozen=True)
class _Sides:
    left: float
    top: float
    right: float
    bottom: float


class RectangleTool(Tool):
    """A drag draws the rectangle; dragged by a side or a corner it is resized, from inside it is moved."""

    def __init__(self) -> None:
        self._press: Press | None = None
        self._before: Box | None = None
        self._grip: frozenset[str] = frozenset()

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: a rectangle to take statistics of | drag its sides or inside: change it | Esc: remove it"

    @property
    def busy(self) -> bool:
        """Whether the rectangle is being dragged."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw or change the rectangle while the button is down."""
        if event.kind is PointerKind.PRESS:
            self._press, self._before = Press(event), host.inspection.region
            self._grip = frozenset() if self._before is None else _grip(_sides(self._before), event)
        elif event.kind in (PointerKind.MOVE, PointerKind.RELEASE) and self._press is not None:
            if self._press.follow(event):
                host.inspection.set_region(self._box(self._press, event, host.session.frame.shape))
            if event.kind is PointerKind.RELEASE:
                self._press = None
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the rectangle back as it was."""
        under_way, self._press = self.busy, None
        if under_way:
            host.inspection.set_region(self._before)
        return under_way

    def remove(self, host: Host) -> bool:
        """Remove the rectangle."""
        there = host.inspection.region is not None
        host.inspection.set_region(None)
        return there

    def _box(self, press: Press, event: PointerEvent, shape: tuple[int, int]) -> Box:
        x, y = press.point
        if self._before is None or not self._grip:
            # whatever pixels the drag has touched
            left, right = sorted((x, event.x))
            top, bottom = sorted((y, event.y))
            return _on_frame(_Sides(math.floor(left), math.floor(top), math.ceil(right), math.ceil(bottom)), shape)
        sides, by = _sides(self._before), {"x": event.x - x, "y": event.y - y}
        if self._grip == _ALL:
            by["x"] = min(max(round(by["x"]), -sides.left), shape[1] - sides.right)
            by["y"] = min(max(round(by["y"]), -sides.top), shape[0] - sides.bottom)
        moved = {side: round(getattr(sides, side) + by[_ALONG[side]]) for side in self._grip}
        return _on_frame(replace(sides, **moved), shape)


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
