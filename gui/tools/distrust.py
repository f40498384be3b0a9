"""Painting measured depth as wrong."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QPainterPath, QPainterPathStroker

from gui.tools.base import Host, Point, Tool, line_path
from gui.tools.brush import brush_preview
from gui.tools.swept import Swept
from gui.views.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import brush_stroke


class DistrustTool(Tool):
    """A stroke marks measured depth as wrong: it counts as missing. With Alt it counts again."""

    options = ("brush",)

    def __init__(self) -> None:
        self._swept: Swept | None = None
        self._trusts = False
        self._points: list[Point] = []

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: this depth is wrong, as behind glass | Alt+drag: trust it again | [ ] or Ctrl+wheel: brush size"

    @property
    def busy(self) -> bool:
        """Whether a stroke is under way."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Sweep while the button is down; the depth counts as missing from the release on."""
        point = event.x, event.y
        if event.kind is PointerKind.PRESS:
            self._swept, self._trusts, self._points = Swept(host.session.frame.shape), event.alt, [point]
            self._sweep(self._swept, point, host)
        elif event.kind is PointerKind.MOVE and self._swept is not None:
            self._sweep(self._swept, point, host)
        elif event.kind is PointerKind.RELEASE and self._swept is not None:
            swept, self._swept = self._swept, None
            self._commit(swept, host)
        area = self._trail(host.options.brush_radius) if self.busy else None
        host.show_preview(None if event.kind is PointerKind.LEAVE else brush_preview(event, host, area))
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Drop the stroke."""
        under_way, self._swept = self.busy, None
        host.show_preview(None)
        return under_way

    def _sweep(self, swept: Swept, point: Point, host: Host) -> None:
        stroke = brush_stroke(host.session.frame.shape, [self._points[-1], point], host.options.brush_radius)
        self._points.append(point)
        if stroke is not None:
            swept.add(stroke)

    def _commit(self, swept: Swept, host: Host) -> None:
        frame = host.session.frame
        before = np.zeros(frame.shape, bool) if frame.distrusted is None else frame.distrusted
        measured = swept.mask & np.isfinite(frame.measured)
        mask = before & ~measured if self._trusts else before | measured
        text = "Trust depth again" if self._trusts else "Distrust depth"
        if not np.array_equal(mask, before):
            host.distrust(mask, text)
        elif self._trusts:
            host.say("None of this depth was distrusted.")
        else:
            host.say("There is no measured depth here that is not distrusted already.")

    def _trail(self, radius: float) -> QPainterPath:
        stroker = QPainterPathStroker()
        stroker.setWidth(2 * max(radius, 0.5))
        stroker.setCapStyle(Qt.PenCapStyle.RoundCap)
        stroker.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        points = self._points
        trail = stroker.createStroke(line_path(points if points[0] != points[-1] else [*points, _beside(points[0])]))
        trail.setFillRule(Qt.FillRule.WindingFill)
        return trail


def _beside(point: Point) -> Point:
    """So near that a line to it is a dot, which has no direction otherwise."""
    return point[0] + 1e-3, point[1]
