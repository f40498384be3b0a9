"""The rectangle that statistics and errors are told of."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gui.state.inspection import Inspection
from gui.tools.base import Press
from gui.tools.dragged import DraggedTool
from gui.tools.grips import REACH
from gui.views.pointer import PointerEvent
from ilf.blocks import Box


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
