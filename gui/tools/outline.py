"""Drawing around what shall be one block."""

from __future__ import annotations

import math
from functools import partial

from gui.tools.base import Host, Press, Tool, line_path, refuses, snapped
from gui.tools.pen import Pen
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import assign_outline

_NEAR = 8
"""Pixels of the screen around the first corner within which a click closes the outline."""


class OutlineTool(Tool):
    """Drag around, or click corner by corner: what is inside goes to the chosen block, or becomes a new one."""

    options = ("leash",)

    def __init__(self) -> None:
        self._pen = Pen()
        self._press: Press | None = None
        self._by_clicks = False
        self._new = False
        self._pixel = 1.0

    @property
    def hint(self) -> str:
        """What a drag, a click or a key would do."""
        if self._by_clicks:
            return "Click: next corner | Shift: straight | Enter or double click: close | Backspace: one back"
        return "Drag around, or click corners: give the inside to the chosen block | Ctrl: to a new block"

    @property
    def busy(self) -> bool:
        """Whether an outline has been begun."""
        return self._pen.down

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw; a drag closes at its release."""
        self._pixel = event.pixel
        match event.kind:
            case PointerKind.PRESS:
                self._begin(event, host)
            case PointerKind.MOVE if self._press is not None:
                self._draw(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                self._end(self._press, event, host)
            case PointerKind.HOVER if self._by_clicks:
                self._show(host, event)
            case PointerKind.DOUBLE:
                if len(self._pen.corners) > 2:
                    self.finish(host)
        return True

    def cancel(self, host: Host) -> bool:
        """Drop the outline."""
        under_way, self._press, self._by_clicks = self.busy, None, False
        self._pen.lift()
        host.show_preview(None)
        return under_way

    def finish(self, host: Host) -> bool:
        """Close the outline; with two corners it goes on."""
        if not self._pen.down:
            return False
        line = self._pen.line
        if len(line) < 3:
            host.say("An outline needs three corners.")
            return True
        closing = self._pen.reach(line[0], False, partial(snapped, host, self._pixel))
        self.cancel(host)
        session = host.session
        label = self._target(host) or session.next_label()
        name = session.info(label).name
        outline = line + closing[1:-1]
        if host.commit(assign_outline(session.labels, outline, label, session.locked), f"Outline {name}"):
            host.select([label])
        else:
            host.say(f"The outline gives {name} no pixel that it has not: other blocks in it are locked, or none are.")
        return True

    def take_back(self, host: Host) -> bool:
        """Drop the last corner."""
        if not self._by_clicks:
            return False
        self._pen.take_back()
        if self._pen.down:
            self._show(host)
        else:
            self.cancel(host)
        return True

    def _target(self, host: Host) -> int:
        """The block that gets the inside; 0 for a new one."""
        return 0 if self._new or not host.session.selected else host.session.selected[0]

    def _begin(self, event: PointerEvent, host: Host) -> None:
        if self._pen.down:
            first = self._pen.corners[0]
            if len(self._pen.corners) > 2 and math.dist(first, (event.x, event.y)) <= _NEAR * event.pixel:
                self.finish(host)
            else:
                self._press = Press(event)
            return
        self._new = event.ctrl
        if not refuses(host, self._target(host)):
            self._press = Press(event)
            self._pen.begin(self._press.point)

    def _draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        dragged = press.drags
        if not press.follow(event):
            return
        snap = partial(snapped, host, event.pixel)
        if not dragged and self._by_clicks:
            self._pen.go(press.point, event.shift, snap)
        self._pen.drag((event.x, event.y), event.shift, snap)
        self._show(host)

    def _end(self, press: Press, event: PointerEvent, host: Host) -> None:
        self._press = None
        if press.drags and not self._by_clicks:
            self.finish(host)
            self.cancel(host)
            return
        if not press.drags and self._by_clicks:
            self._pen.go(press.point, event.shift, partial(snapped, host, event.pixel))
        self._pen.rest()
        self._by_clicks = True
        self._show(host)

    def _show(self, host: Host, event: PointerEvent | None = None) -> None:
        line = self._pen.line
        if event is not None:
            line = line + self._pen.reach((event.x, event.y), event.shift, partial(snapped, host, event.pixel))[1:]
        host.show_preview(Preview(line_path(line), self._pen.corners if self._by_clicks else line[:1]))
