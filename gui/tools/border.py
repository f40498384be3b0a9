"""Redrawing a stretch of the border between blocks."""

from __future__ import annotations

from functools import partial

from gui.tools.base import Host, Point, Press, Tool, line_path, snapped
from gui.tools.pen import Pen
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import redraw_border


class BorderTool(Tool):
    """Drag a border as it should be: the blocks at both sides follow. A click chooses a block."""

    options = ("leash",)

    def __init__(self) -> None:
        self._pen = Pen()
        self._press: Press | None = None

    @property
    def hint(self) -> str:
        """What a drag would do."""
        return "Drag: draw a border as it should be | Shift: straight | click: choose a block"

    @property
    def busy(self) -> bool:
        """Whether a line is being drawn."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw while the button is down; both neighbours follow at its release."""
        if event.kind is PointerKind.PRESS:
            self._press = Press(event)
        elif event.kind is PointerKind.MOVE and self._press is not None:
            self._draw(self._press, event, host)
        elif event.kind is PointerKind.RELEASE and self._press is not None:
            press, line = self._press, self._pen.line
            self.cancel(host)
            if press.drags:
                self._redraw(line, host)
            else:
                label = host.session.label_at(*press.point)
                host.select([label] if label else [])
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Drop the line."""
        under_way, self._press = self.busy, None
        self._pen.lift()
        host.show_preview(None)
        return under_way

    def _draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        if not press.follow(event):
            return
        if not self._pen.down:
            self._pen.begin(press.point)
        self._pen.drag((event.x, event.y), event.shift, partial(snapped, host, event.pixel))
        host.show_preview(Preview(line_path(self._pen.line)))

    def _redraw(self, line: list[Point], host: Host) -> None:
        session = host.session
        if not host.commit(redraw_border(session.labels, line, session.locked), "Redraw border"):
            host.say("The line moves no border: begin and end it on borders, or beside the one that it replaces.")
