"""Drawing around what shall be one block."""

from __future__ import annotations

import math

from gui.tools.base import Host, Press, refuses
from gui.tools.line import LineTool
from gui.views.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import assign_outline

_NEAR = 8
"""Pixels of the screen around the first corner within which a click closes the outline."""


class OutlineTool(LineTool):
    """Drag around, or click corner by corner: what is inside goes to the chosen block, or becomes a new one."""

    def __init__(self) -> None:
        super().__init__()
        self._new = False

    @property
    def hint(self) -> str:
        """What a drag, a click or a key would do."""
        if self._by_clicks:
            return "Click: next corner | Shift: straight | Enter or double click: close | Backspace: one back"
        return "Drag around, or click corners: give the inside to the chosen block | Ctrl: to a new block"

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw; a drag closes at its release."""
        match event.kind:
            case PointerKind.PRESS:
                self._begin(event, host)
            case PointerKind.MOVE if self._press is not None:
                self._drag(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                self._end(press, event, host)
            case PointerKind.HOVER if self._by_clicks:
                self._show(host, event)
            case PointerKind.DOUBLE:
                if len(self._pen.corners) > 2:
                    self.finish(host)
        return True

    def finish(self, host: Host) -> bool:
        """Close the outline; with two corners it goes on."""
        if not self._pen.down:
            return False
        line = self._pen.line
        if len(line) < 3:
            host.say("An outline needs three corners.")
            return True
        closing = self._pen.reach(line[0], False, self._snap(host))
        self.cancel(host)
        session = host.session
        label = self._target(host) or session.next_label()
        name = session.info(label).name
        outline = line + closing[1:-1]
        if host.commit(assign_outline(session.labels, outline, label, session.locked), f"Outline {name}"):
            host.select([label])
        else:
            host.say(f"The outline gives {name} no pixel: it has those inside already, or they are of locked blocks.")
        return True

    def _target(self, host: Host) -> int:
        """The block that gets the inside; 0 for a new one."""
        return 0 if self._new or not host.session.selected else host.session.selected[0]

    def _begin(self, event: PointerEvent, host: Host) -> None:
        if not self._pen.down:
            self._new = event.ctrl
            if not refuses(host, self._target(host)):
                self._press = Press(event)
        elif self._closes(event):
            self.finish(host)
        else:
            self._press = Press(event)

    def _closes(self, event: PointerEvent) -> bool:
        corners = self._pen.corners
        return len(corners) > 2 and math.dist(corners[0], (event.x, event.y)) <= _NEAR * event.pixel

    def _end(self, press: Press, event: PointerEvent, host: Host) -> None:
        if not press.drags:
            self._click(press.point, event.shift, host)
        elif self._by_clicks:
            self._pen.rest()
        else:
            self.finish(host)
            self.cancel(host)
