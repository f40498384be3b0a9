"""The crosshair that keys move: a pointer for the tools without a mouse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt

from ..views.interaction import ARROWS, PointerEvent, PointerKind
from ..views.linked_views import LinkedViews
from .editor import Editor

FAR = 10
"""Pixels of a long step."""
_ABOUT = (
    "Arrow keys move the crosshair (Shift: 10 px, Ctrl: to the next border). Space clicks; hold it and move to drag."
)


class Crosshair:
    """A pixel of the frame that keys move, and where they click and drag.

    The mouse takes over when it moves, except during a drag by keys.
    """

    def __init__(self, editor: Editor, views: LinkedViews) -> None:
        self._editor = editor
        self._views = views
        self._at: tuple[int, int] | None = None
        self._press: PointerEvent | None = None
        self._explained = False
        self.active = False
        """Whether keys have moved it since the mouse was moved last."""

    def show(self) -> None:
        """Show it where the mouse was last, where it was before, or in the middle of what is seen."""
        seen = self._views.active.view.visible_box()
        middle = (seen[1].start + seen[1].stop) // 2, (seen[0].start + seen[0].stop) // 2
        self._put(*((self._at if self.active else None) or self._views.navigation.pixel or self._at or middle))
        if not self._explained:
            self._explained = True
            self._editor.show_message(_ABOUT)

    def move(self, key: int, far: bool, to_border: bool) -> None:
        """Move it by an arrow key: by a pixel, by `FAR`, or to the next border of blocks."""
        if not self.active or self._at is None:
            self.show()
        assert self._at is not None
        along, down = ARROWS[key]
        step = self._to_border(along, down) if to_border else FAR if far else 1
        self._put(self._at[0] + step * along, self._at[1] + step * down)

    def press(self, modifiers: Qt.KeyboardModifier) -> None:
        """Press the button, with modifiers that hold until it is released."""
        self._press = replace(
            self._event(PointerKind.PRESS),
            shift=bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
            ctrl=bool(modifiers & Qt.KeyboardModifier.ControlModifier),
            alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        )
        self._editor.pointer(self._press)

    def release(self) -> None:
        """Release the button."""
        if self._press is not None:
            event = self._event(PointerKind.RELEASE)
            self._press = None
            self._editor.pointer(event)

    def give_way(self, event: PointerEvent) -> bool:
        """Leave the tool to the mouse when it moves or presses; False during a drag by keys."""
        if event.kind in (PointerKind.HOVER, PointerKind.PRESS):
            self.active &= self._press is not None
        return self._press is None

    def _put(self, x: int, y: int) -> None:
        """Put it on a pixel, or on the next one of the frame, and keep that in sight."""
        height, width = self._editor.document.frame.shape
        x, y = min(max(x, 0), width - 1), min(max(y, 0), height - 1)
        rows, columns = self._views.active.view.visible_box()
        if not (rows.start <= y < rows.stop and columns.start <= x < columns.stop):
            self._views.set_place(x + 0.5, y + 0.5, 1 / self._views.pixel_size)
        self._at, self.active = (x, y), True
        self._views.point_at(self._at)
        self._editor.pointer(self._event(PointerKind.HOVER if self._press is None else PointerKind.MOVE))

    def _event(self, kind: PointerKind) -> PointerEvent:
        assert self._at is not None
        x, y = self._at[0] + 0.5, self._at[1] + 0.5
        if self._press is not None:
            return replace(self._press, kind=kind, x=x, y=y)
        return PointerEvent(kind, x, y, pixel=self._views.pixel_size)

    def _to_border(self, along: int, down: int) -> int:
        """Return the number of pixels to the next block in a direction, or to the end of the frame."""
        assert self._at is not None
        x, y = self._at
        labels = self._editor.document.labels
        line, start = (labels[y], x) if along else (labels[:, x], y)
        ahead = line[start :: along + down]
        others = np.flatnonzero(ahead != ahead[0])
        return int(others[0]) if len(others) else len(ahead)
