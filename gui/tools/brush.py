"""Painting block pixels: add to the chosen block, or take from it."""

from __future__ import annotations

from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath

from gui.tools.base import Host
from gui.views.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import brush_stroke, erase, paint


class BrushTool:
    """One stroke, from press to release, is one undoable step.

    Adding paints with the chosen block, or with the one under the press if none is chosen; erasing takes pixels
    from that block alone. Alt swaps adding and erasing for one stroke.
    """

    def __init__(self, erases: bool) -> None:
        act = "take pixels from the block" if erases else "add pixels to the block"
        other = "add" if erases else "erase"
        self.hint = f"Drag: {act} | Alt+drag: {other} | [ and ]: brush size | Esc: give the stroke up"
        self._erases = erases
        self._strokes = False
        self._last = (0.0, 0.0)
        self._label = 0
        self._erasing = erases

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Paint while the button is down; show the brush otherwise."""
        host.show_preview(None if event.kind is PointerKind.LEAVE else self._outline(event, host))
        if event.kind is PointerKind.PRESS:
            self._begin(event, host)
            return True
        if self._strokes and event.kind is PointerKind.MOVE:
            self._sweep((event.x, event.y), host)
        elif event.kind is PointerKind.RELEASE:
            self._end(host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the stroke's pixels back."""
        under_way, self._strokes = self._strokes, False
        host.drop_stroke()
        return under_way

    def _begin(self, event: PointerEvent, host: Host) -> None:
        session = host.session
        chosen = session.selected
        self._label = chosen[0] if chosen else session.label_at(event.x, event.y)
        self._erasing = self._erases != event.alt
        if self._label == 0:
            host.say("Choose a block first, or start a new one with Blocks > New block.")
            return
        if self._label in session.locked:
            host.say(f"{session.info(self._label).name} is locked. Unlock it in the table of blocks.")
            return
        if chosen != [self._label]:
            host.select([self._label])
        self._strokes = True
        self._last = (event.x, event.y)
        self._sweep(self._last, host)

    def _sweep(self, point: tuple[float, float], host: Host) -> None:
        session = host.session
        stroke = brush_stroke(session.labels.shape, [self._last, point], host.brush_radius)
        self._last = point
        if stroke is None:
            return
        change = erase if self._erasing else paint
        host.stroke(change(session.labels, stroke, self._label, session.locked))

    def _end(self, host: Host) -> None:
        if not self._strokes:
            return
        self._strokes = False
        name = host.session.info(self._label).name
        host.end_stroke(f"Erase from {name}" if self._erasing else f"Paint {name}")

    def _outline(self, event: PointerEvent, host: Host) -> QPainterPath:
        path = QPainterPath()
        radius = max(host.brush_radius, 0.5)
        path.addEllipse(QPointF(event.x, event.y), radius, radius)
        return path
