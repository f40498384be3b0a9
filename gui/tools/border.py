"""Redrawing a stretch of the border between blocks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from gui.state.session import touched_by
from gui.tools.base import Host, Point, Press, refuses_one
from gui.tools.line import LineTool
from gui.tools.outlook import Outlook, of_patch
from gui.tools.select import choose
from gui.views.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import LabelPatch, redraw_border


class BorderTool(LineTool):
    """Drag a border as it should be: the blocks at both sides follow. A click chooses a block."""

    @property
    def hint(self) -> str:
        """What a drag would do."""
        if self._outlook is not None:
            return f"Release: {self._outlook.text} | Shift: straight | Esc: give up"
        return "Drag: draw a border as it should be | Shift: straight | click: choose a block"

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw while the button is down; both neighbours follow at its release."""
        if event.kind is PointerKind.PRESS:
            self._press = Press(event)
        elif event.kind is PointerKind.MOVE and self._press is not None:
            self._drag(self._press, event, host)
        elif event.kind is PointerKind.RELEASE and self._press is not None:
            press, line = self._press, self._pen.line
            self.cancel(host)
            if press.drags:
                _redraw(line, host)
            else:
                choose(press.point, event, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], LabelPatch | None]:
        """The change that the line would make."""
        return partial(redraw_border, host.session.labels.copy(), line)

    def outlook(self, answer: LabelPatch | None, host: Host) -> Outlook:
        """Whose pixels would go where."""
        return of_patch(host.session, answer)


def _redraw(line: list[Point], host: Host) -> None:
    session = host.session
    if host.commit(redraw_border(session.labels, line, session.locked), "Redraw border"):
        return
    swept = redraw_border(session.labels, line)
    if swept is None or not refuses_one(host, touched_by(swept)):
        host.say(
            "The line moves no border: draw it beside the one that it replaces. Give cuts a part off along a line."
        )
