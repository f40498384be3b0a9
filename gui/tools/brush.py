"""Painting block pixels: add to the chosen block, or take from it."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath

from gui.tools.base import Host, Point, Tool, knows_edges, refuses, refuses_one
from gui.tools.swept import Swept
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import Stroke, brush_stroke, erase, paint
from ilf.ebs.similar import Similar


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
