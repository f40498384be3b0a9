"""Cutting a block along a line."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from gui.tools.base import Host, Point, Press, Tool, knows_edges, line_path, refuses, snapped
from gui.tools.crossing import crossed
from gui.tools.pen import Pen
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import split
from ilf.ebs.splitting import suggest_split


@dataclass(frozen=True)
class _Offer:
    label: int
    line: list[Point]


class SplitTool(Tool):
    """Draw a line right across a block, freely or from click to click; or take the one that a click suggests."""

    options = ("leash",)

    def __init__(self) -> None:
        self._pen = Pen()
        self._press: Press | None = None
        self._by_clicks = False
        self._offer: _Offer | None = None

    @property
    def hint(self) -> str:
        """What a drag, a click or a key would do."""
        if self._offer is not None:
            return "Click or Enter: cut along this line | drag: draw another | Esc: give up"
        if self._by_clicks:
            return "Click: next point | Shift: straight | Enter or double click: cut | Backspace: one back"
        return "Drag: cut along a line | Shift: straight | click: suggest a line | Ctrl+click: point by point"

    @property
    def busy(self) -> bool:
        """Whether there is a line, drawn or suggested."""
        return self._press is not None or self._pen.down or self._offer is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw; a drag cuts at its release."""
        match event.kind:
            case PointerKind.PRESS:
                self._press = Press(event)
            case PointerKind.MOVE if self._press is not None:
                self._draw(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                if press.drags:
                    self._end_drag(host)
                else:
                    self._click(press.point, event, host)
            case PointerKind.HOVER if self._by_clicks:
                self._show(host, event)
            case PointerKind.DOUBLE:
                if not self._by_clicks:  # the second of two quick clicks takes what the first has suggested
                    return False
                self.finish(host)
        return True

    def cancel(self, host: Host) -> bool:
        """Drop the line."""
        under_way = self.busy
        self._press = self._offer = None
        self._by_clicks = False
        self._pen.lift()
        host.show_preview(None)
        return under_way

    def finish(self, host: Host) -> bool:
        """Cut along the line as it lies."""
        offer, line = self._offer, self._pen.line
        if offer is None and len(line) < 2:
            return False
        self.cancel(host)
        if offer is not None:
            _cut(offer.label, offer.line, host)
        else:
            found = crossed(host.session.labels, line)
            chosen = [label for label in host.session.selected[:1] if label in found]
            _cut((chosen or list(found) or [0])[0], line, host)
        return True

    def take_back(self, host: Host) -> bool:
        """Drop the last point."""
        if not self._by_clicks:
            return False
        self._pen.take_back()
        if self._pen.down:
            self._show(host)
        else:
            self.cancel(host)
        return True

    def _draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        dragged = press.drags
        if not press.follow(event):
            return
        self._offer = None
        snap = partial(snapped, host, event.pixel)
        if not self._pen.down:
            self._pen.begin(press.point)
        elif not dragged:
            self._pen.go(press.point, event.shift, snap)
        self._pen.drag((event.x, event.y), event.shift, snap)
        self._show(host)

    def _end_drag(self, host: Host) -> None:
        if self._by_clicks:
            self._pen.rest()
        else:
            self.finish(host)

    def _click(self, point: Point, event: PointerEvent, host: Host) -> None:
        if self._by_clicks:
            self._pen.go(point, event.shift, partial(snapped, host, event.pixel))
        elif self._offer is not None and not event.ctrl:
            self.finish(host)
            return
        elif event.ctrl or not self._suggest(point, host):
            self._offer = None
            self._by_clicks = True
            self._pen.begin(point)
        self._show(host)

    def _suggest(self, point: Point, host: Host) -> bool:
        """Offer a line for the block at a point; False if a line may be begun there instead."""
        label = host.session.label_at(*point)
        if label == 0:
            return False
        if refuses(host, label) or not knows_edges(host):
            return True
        line = _suggestion(host, label)
        if line is None:
            host.say(f"Nothing tells two surfaces in {host.session.info(label).name} apart: click on, point by point.")
            return False
        self._offer = _Offer(label, line)
        return True

    def _show(self, host: Host, event: PointerEvent | None = None) -> None:
        if self._offer is not None:
            host.show_preview(Preview(line_path(self._offer.line), dashed=True))
            return
        line = self._pen.line
        if event is not None:
            line = line + self._pen.reach((event.x, event.y), event.shift, partial(snapped, host, event.pixel))[1:]
        host.show_preview(Preview(line_path(line), self._pen.corners if self._by_clicks else ()))


def suggested_cut(host: Host, label: int) -> None:
    """Cut a block at once where its depth and edges suggest it."""
    if refuses(host, label) or not knows_edges(host):
        return
    line = _suggestion(host, label)
    if line is None:
        host.say(f"Nothing tells two surfaces in {host.session.info(label).name} apart. Draw the line with Split.")
    else:
        _cut(label, line, host)


def _suggestion(host: Host, label: int) -> list[Point] | None:
    session, guide = host.session, host.guide
    line = None if guide is None else suggest_split(session.frame, session.labels, label, guide.strength)
    return None if line is None else list(line)


def _cut(label: int, line: list[Point], host: Host) -> None:
    session = host.session
    if label == 0:
        host.say("The line crosses no block.")
        return
    name = session.info(label).name
    if refuses(host, label):
        return
    if host.commit(split(session.labels, label, line, session.locked, session.next_label()), f"Split {name}"):
        host.select([label])
    else:
        host.say(f"The line does not part {name}: draw it from boundary to boundary.")
