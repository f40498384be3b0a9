"""What the tools share that draw a line: freely in a drag, or from click to click."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from gui.tools.base import Host, Point, Press, Tool, line_path, snapped
from gui.tools.grips import REACH
from gui.tools.outlook import Outlook
from gui.tools.pen import Pen, Snap
from gui.views.pointer import PointerEvent
from gui.views.preview import Preview


class LineTool(Tool):
    """A line under way. It snaps as far as the leash allows; with Shift it is straight."""

    options = ("leash",)

    def __init__(self) -> None:
        self._pen = Pen()
        self._press: Press | None = None
        self._by_clicks = False
        self._pixel = 1.0
        self._shown: list[Point] = []
        self._outlook: Outlook | None = None
        """What is known to come of the line, or of how it was a moment ago."""

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], Any] | None:
        """What finds out, off the GUI's thread, what would come of a line; None if nothing can be told."""
        return None

    def outlook(self, answer: Any, host: Host) -> Outlook:
        """What has been found out by what `look_ahead` gave."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether there is a line, or the button is down."""
        return self._press is not None or self._pen.down

    def cancel(self, host: Host) -> bool:
        """Drop the line."""
        under_way, self._press, self._by_clicks = self.busy, None, False
        self._pen.lift()
        self._outlook = None
        host.show_preview(None)
        return under_way

    def take_back(self, host: Host) -> bool:
        """Drop what the last click has added."""
        if not self._by_clicks:
            return False
        self._pen.take_back()
        if self._pen.down:
            self._show(host)
        else:
            self.cancel(host)
        return True

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Draw on while the button is down; False as long as this may yet be a click."""
        dragged = press.drags
        if not press.follow(event):
            return False
        self._pixel = event.pixel
        snap = self._snap(host)
        if not self._pen.down:
            self._pen.begin(press.point)
        elif not dragged:
            self._pen.go(press.point, event.shift, snap)
        self._pen.drag((event.x, event.y), event.shift, snap)
        self._show(host)
        return True

    def _click(self, point: Point, straight: bool, host: Host) -> None:
        """Go on to a point, or begin there."""
        self._by_clicks = True
        if self._pen.down:
            self._pen.go(point, straight, self._snap(host))
        else:
            self._pen.begin(point)
        self._show(host)

    def _show(self, host: Host, event: PointerEvent | None = None) -> None:
        """Show the line, and from click to click how it would go on to the pointer."""
        line = self._pen.line
        if event is not None:
            self._pixel = event.pixel
            line = line + self._pen.reach((event.x, event.y), event.shift, self._snap(host))[1:]
        self._shown = line
        self._draw(host)
        find = self.look_ahead(line, host) if len(line) > 1 else None
        if find is not None:
            host.work_out(find, partial(self._take_outlook, host))

    def _take_outlook(self, host: Host, answer: Any) -> None:
        if self._pen.down:
            self._outlook = self.outlook(answer, host)
            self._draw(host)

    def _draw(self, host: Host) -> None:
        corners = self._pen.corners if self._by_clicks else self._shown[:1]
        path = None if self._outlook is None else self._outlook.path
        host.show_preview(Preview(line_path(self._shown), corners, outlook=path))

    @property
    def _near(self) -> float:
        """How far a line may miss what it is drawn to, in pixels of the image."""
        return REACH * self._pixel

    def _snap(self, host: Host) -> Snap:
        """How a stretch is moved onto edges, as near as the view is now."""
        return partial(snapped, host, self._pixel)
