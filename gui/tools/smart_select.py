"""The tool Smart select: selects a surface or object by clicks or a box, and makes it a block."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from ilf.segmentation.editing.cleaning import pixels_apart
from ilf.segmentation.editing.painting import give
from ilf.segmentation.selection import select_region

from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Press, Tool, warn_if_locked
from .give import piece_preview
from .line_preview import disconnected_text

Mask = NDArray[np.bool_]

_CROSS = 4.0
"""Half the width of the cross at a point that was taken away [screen pixels]."""


@dataclass(frozen=True)
class _Click:
    """A point that is added or taken away, and its steps from part to object."""

    point: Point
    inside: bool
    steps: int = 0


@dataclass(frozen=True)
class _Clicks:
    """What determines a selection: clicks in order, a box, and the steps of the next click."""

    clicks: tuple[_Click, ...] = ()
    box: QRectF | None = None
    steps: int = 0

    def points(self, inside: bool) -> list[Point]:
        """The points inside, or those outside."""
        return [click.point for click in self.clicks if click.inside == inside]

    def stepped(self, steps: int) -> _Clicks:
        """The same with further steps at the last point inside, or at the next one if there is none."""
        inside = [number for number, click in enumerate(self.clicks) if click.inside]
        if not inside:
            return replace(self, steps=self.steps + steps)
        last = self.clicks[inside[-1]]
        changed = (*self.clicks[: inside[-1]], replace(last, steps=last.steps + steps), *self.clicks[inside[-1] + 1 :])
        return replace(self, clicks=changed)


class SmartSelectTool(Tool):
    """The tool Smart select. Clicks add what is under them to the selection, with Alt they take it away; a drag draws a
    box; Ctrl+wheel steps from part to object. Enter gives the selection to the selected block, or makes a new one.

    Without a click, the preview shows what a click would select.
    """

    wheel = True

    def __init__(self) -> None:
        self._press: Press | None = None
        self._clicks = _Clicks()
        self._new = False
        self._mask: Mask | None = None
        """The selection; None while it is being computed."""
        self._finishes = False
        """Whether Enter was pressed while the selection was being computed."""
        self._pixel = 1.0

    @property
    def hint(self) -> str:
        """Hint: what a click, a drag or a key would do."""
        if self._selects:
            return (
                "Click: add | Alt+click: take away | Ctrl+wheel: part or object | Enter: make it a block | "
                "Backspace: remove last | Esc: cancel"
            )
        return "Click or drag a box: select for the selected block | Ctrl: for a new block | Ctrl+wheel: part or object"

    @property
    def busy(self) -> bool:
        """Whether there is a selection, or the button is pressed."""
        return self._press is not None or self._selects

    @property
    def _selects(self) -> bool:
        return bool(self._clicks.clicks) or self._clicks.box is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Add a point or a box on release; step with the wheel; otherwise show what a click would select."""
        self._pixel = event.pixel
        match event.kind:
            case PointerKind.PRESS:
                self._press = Press(event)
            case PointerKind.MOVE if self._press is not None and self._press.follow(event):
                band = QPainterPath()
                band.addRect(_band(self._press, event))
                host.show_preview(Preview(band, dashed=True))
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                self._add(press, event, host)
            case PointerKind.WHEEL:
                self._clicks = self._clicks.stepped(event.steps)
                self._update(host, (event.x, event.y))
            case PointerKind.HOVER if not self._selects:
                self._update(host, (event.x, event.y))
            case PointerKind.LEAVE if not self._selects:
                host.show_preview(None)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> bool:
        """Drop the selection."""
        pending_work, self._press, self._clicks = self.busy, None, _Clicks()
        self._mask, self._finishes = None, False
        host.show_preview(None)
        return pending_work

    def undo_last(self, host: Host) -> bool:
        """Remove the last point, or else the box."""
        if not self._selects:
            return False
        clicks = self._clicks.clicks
        self._clicks = _Clicks(clicks[:-1], self._clicks.box) if clicks else _Clicks()
        if self._selects:
            self._update(host, None)
        else:
            self.cancel(host)
        return True

    def finish(self, host: Host) -> bool:
        """Give the selection to the selected block, or make it a new one."""
        if not self._selects:
            return False
        mask, self._finishes = self._mask, self._mask is None
        if mask is None:
            return True
        session = host.session
        label = session.next_label() if self._new or not session.selected else session.selected[0]
        if warn_if_locked(host, label):
            return True
        name = session.info(label).name
        patch = give(session.labels, mask, label, session.locked)
        apart = pixels_apart(session.labels, patch, label)
        self.cancel(host)
        if not host.commit(patch, f"Smart select {name}"):
            host.show_message(f"The selection adds no pixels to {name}: they are in it already, or in locked blocks.")
            return True
        host.select([label])
        if apart:
            host.show_message(f"{disconnected_text(name, apart)} Hold Ctrl at the first click to make a new block.")
        return True

    def _add(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Add a point, or start anew with a box."""
        height, width = host.session.labels.shape
        if not self._selects:
            self._new = event.ctrl
        if press.drags:
            box = _band(press, event).intersected(QRectF(0, 0, width, height))
            self._clicks = _Clicks() if box.isEmpty() else _Clicks(box=box)
        elif 0 <= event.x < width and 0 <= event.y < height:
            inside = not event.alt
            if not inside and not self._selects:
                host.show_message("There is nothing to take away yet: click what you want to select first.")
                return
            click = _Click((event.x, event.y), inside, self._clicks.steps)
            self._clicks = _Clicks((*self._clicks.clicks, click), self._clicks.box)
        if self._selects:
            self._update(host, None)
        else:
            host.show_preview(None)

    def _update(self, host: Host, pointer: Point | None) -> None:
        """Compute the selection, or what a click at the pointer would select, in the background."""
        clicks, frame = self._clicks, host.session.frame
        inside, outside, box = clicks.points(inside=True), clicks.points(inside=False), clicks.box
        steps = [click.steps for click in clicks.clicks if click.inside]
        if self._selects:
            self._mask = None
        elif pointer is not None and 0 <= pointer[0] < frame.shape[1] and 0 <= pointer[1] < frame.shape[0]:
            inside, steps = [pointer], [clicks.steps]
        else:
            host.show_preview(None)
            return
        corners = None if box is None else (box.left(), box.top(), box.right(), box.bottom())
        find = partial(select_region, frame, inside, outside, corners, steps=steps)
        host.run_in_background(find, partial(self._take, host, clicks))

    def _take(self, host: Host, clicks: _Clicks, mask: Mask) -> None:
        if clicks is not self._clicks or self._press is not None:
            return
        if self._selects:
            self._mask = mask
        self._show(host, mask)
        if self._finishes:
            self.finish(host)

    def _show(self, host: Host, mask: Mask) -> None:
        """Show the outline of a mask, a square at each point inside and a cross at each point outside."""
        path, half = QPainterPath(), _CROSS * self._pixel
        if mask.any():
            path.addPath(piece_preview(mask).line)
        for x, y in self._clicks.points(inside=False):
            for slope in (-1, 1):
                path.moveTo(x - half, y - slope * half)
                path.lineTo(x + half, y + slope * half)
        host.show_preview(Preview(path, self._clicks.points(inside=True), dashed=not self._selects))


def _band(press: Press, event: PointerEvent) -> QRectF:
    x, y = press.point
    return QRectF(x, y, event.x - x, event.y - y).normalized()
