"""Painting block pixels: add to the chosen block, or take from it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath

from gui.tools.base import Host, label_at
from gui.tools.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import brush_stroke, erase, paint, patch_between


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
        self._before: NDArray[np.int32] | None = None
        self._last = (0.0, 0.0)
        self._label = 0
        self._erasing = erases

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Paint while the button is down; show the brush otherwise."""
        host.show_preview(None if event.kind is PointerKind.LEAVE else self._outline(event, host))
        if event.kind is PointerKind.PRESS:
            self._begin(event, host)
            return True
        if self._before is not None and event.kind is PointerKind.MOVE:
            self._sweep((event.x, event.y), host)
        elif event.kind is PointerKind.RELEASE:
            self._end(host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the stroke's pixels back."""
        if self._before is None:
            return False
        host.session.set_labels(self._before)
        self._before = None
        host.show_labels(_everything(host.session.labels))
        return True

    def _begin(self, event: PointerEvent, host: Host) -> None:
        session = host.session
        chosen = session.selected
        self._label = chosen[0] if chosen else label_at(session, event.x, event.y)
        self._erasing = self._erases != event.alt
        if self._label == 0:
            host.say("Choose a block first, or start a new one with Blocks > New block.")
            return
        if self._label in session.locked:
            host.say(f"{session.info(self._label).name} is locked. Unlock it in the table of blocks.")
            return
        if chosen != [self._label]:
            host.select([self._label])
        self._before = session.labels.copy()
        self._last = (event.x, event.y)
        self._sweep(self._last, host)

    def _sweep(self, point: tuple[float, float], host: Host) -> None:
        session = host.session
        stroke = brush_stroke(session.labels.shape, [self._last, point], host.brush_radius)
        self._last = point
        if stroke is None:
            return
        change = erase if self._erasing else paint
        patch = change(session.labels, stroke, self._label, session.locked)
        if patch is not None:
            session.apply(patch)
            host.show_labels(patch.box)

    def _end(self, host: Host) -> None:
        before, self._before = self._before, None
        if before is None:
            return
        name = host.session.info(self._label).name
        text = f"Erase from {name}" if self._erasing else f"Paint {name}"
        host.commit(patch_between(before, host.session.labels), text, done=True)

    def _outline(self, event: PointerEvent, host: Host) -> QPainterPath:
        path = QPainterPath()
        radius = max(host.brush_radius, 0.5)
        path.addEllipse(QPointF(event.x, event.y), radius, radius)
        return path


def _everything(labels: NDArray[np.int32]) -> tuple[slice, slice]:
    return slice(0, labels.shape[0]), slice(0, labels.shape[1])
