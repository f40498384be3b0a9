"""Painting block pixels: add to the chosen block, or take from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainterPath, QPainterPathStroker

from ilf.data.blocks import Box
from ilf.segmentation.editing.painting import Stroke, brush_stroke, erase, paint
from ilf.segmentation.editing.snapping import Similar

from ..state.stroke import around
from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Tool, knows_edges, line_path, refuses, refuses_one

# All that a brush has swept since the button went down.


class Swept:
    """Pixels of several short strokes together."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.mask: NDArray[np.bool_] = np.zeros(shape, bool)
        self._box: Box | None = None

    def add(self, stroke: Stroke) -> None:
        """Take in a stroke's pixels."""
        self.mask[stroke.box] |= stroke.mask
        self._box = stroke.box if self._box is None else around(self._box, stroke.box)

    @property
    def stroke(self) -> Stroke | None:
        """All of them; None if there are none."""
        return None if self._box is None else Stroke(self._box, self.mask[self._box])


class BrushTool(Tool):
    """One stroke, from press to release, is one undoable step.

    Adding paints with the chosen block, or with the one under the press if none is chosen; erasing takes pixels
    from that block alone, and gives them to neighbours at the release. Alt swaps adding and erasing for one stroke.
    """

    def __init__(self, erases: bool) -> None:
        self.options = ("brush", "similar", "no_block") if erases else ("brush", "similar")
        self._erases = erases
        self._erasing = erases
        self._swept: Swept | None = None
        self._similar: Similar | None = None
        self._last: Point = (0.0, 0.0)
        self._label = 0

    @property
    def hint(self) -> str:
        """What a drag would do."""
        act = "take pixels from the block" if self._erases else "add pixels to the block"
        other = "add" if self._erases else "erase"
        return f"Drag: {act} | Alt+drag: {other} | [ ] or Ctrl+wheel: brush size"

    @property
    def busy(self) -> bool:
        """Whether a stroke is under way."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Paint while the button is down; show the brush otherwise."""
        host.show_preview(None if event.kind is PointerKind.LEAVE else brush_preview(event, host))
        if event.kind is PointerKind.PRESS:
            self._begin(event, host)
        elif self._swept is not None and event.kind is PointerKind.MOVE:
            self._sweep(self._swept, (event.x, event.y), host)
        elif self._swept is not None and event.kind is PointerKind.RELEASE:
            self._end(self._swept, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the stroke's pixels back."""
        under_way, self._swept = self.busy, None
        host.drop_stroke()
        return under_way

    def _begin(self, event: PointerEvent, host: Host) -> None:
        session = host.session
        chosen = session.selected
        self._label = chosen[0] if chosen else session.label_at(event.x, event.y)
        self._erasing = self._erases != event.alt
        if self._label == 0:
            host.say("Choose a block first, or start a new one with Blocks > New block.")
        elif not refuses(host, self._label) and self._look_around(event, host):
            if chosen != [self._label]:
                host.select([self._label])
            self._swept = Swept(session.labels.shape)
            self._last = event.x, event.y
            self._sweep(self._swept, self._last, host)

    def _look_around(self, event: PointerEvent, host: Host) -> bool:
        """Find what the stroke keeps to; False if that cannot be known yet."""
        self._similar = None
        if not host.options.similar_only:
            return True
        aid = host.aid
        if not knows_edges(host) or aid is None:
            return False
        self._similar = Similar(aid.frame, aid.strength, event.x, event.y)
        return True

    def _sweep(self, swept: Swept, point: Point, host: Host) -> None:
        session = host.session
        stroke: Stroke | None = brush_stroke(session.labels.shape, [self._last, point], host.options.brush_radius)
        self._last = point
        if stroke is not None and self._similar is not None:
            stroke = self._similar.limit(stroke)
        if stroke is None:
            return
        swept.add(stroke)
        change = erase if self._erasing else paint
        host.stroke(change(session.labels, stroke, self._label, session.locked))

    def _end(self, swept: Swept, host: Host) -> None:
        self._swept = None
        session = host.session
        name = session.info(self._label).name
        if not self._erasing:
            if not host.end_stroke(f"Paint {name}"):
                refuses_one(host, np.unique(session.labels[swept.mask]).tolist())
            return
        text = f"Erase from {name}"
        if host.options.to_no_block:
            host.end_stroke(text)
            return
        host.drop_stroke()  # where the pixels belong can be told only of all of them together
        if swept.stroke is not None:
            host.commit(erase(session.labels, swept.stroke, self._label, session.locked, frame=session.frame), text)


def brush_preview(event: PointerEvent, host: Host, area: QPainterPath | None = None) -> Preview:
    """The brush at a place, and an area that it has swept."""
    path = QPainterPath()
    radius = max(host.options.brush_radius, 0.5)
    path.addEllipse(QPointF(event.x, event.y), radius, radius)
    return Preview(path, area=area)


# Painting measured depth as wrong.


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
