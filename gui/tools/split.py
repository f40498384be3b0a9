"""Cutting a block along a line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from ilf.segmentation.editing.cutting import run_on, split, suggest_split
from ilf.segmentation.editing.patches import Labels

from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Press, crossed, is_thick, knows_edges, line_path, refuses
from .line import LineTool
from .outlook import Outlook


@dataclass(frozen=True)
class _Offer:
    label: int
    line: list[Point]


class SplitTool(LineTool):
    """Draw a line right across a block, freely or from click to click; or take the one that a click suggests."""

    def __init__(self) -> None:
        super().__init__()
        self._offer: _Offer | None = None
        self._asked: tuple[int, Point] | None = None
        self._at_once = False

    @property
    def hint(self) -> str:
        """What a drag, a click or a key would do."""
        if self._asked is not None:
            return "Looking for a line that parts two surfaces… | Enter: cut along it at once | Esc: give up"
        if self._offer is not None:
            return "Click or Enter: cut along this line | drag: draw another | Esc: give up"
        cut = "cut" if self._outlook is None else self._outlook.text
        if self._by_clicks:
            return f"Click: next point | Shift: straight | Enter or double click: {cut} | Backspace: one back"
        if self._outlook is not None:
            return f"Release: {cut} | Shift: straight | Esc: give up"
        return "Drag: cut along a line | Shift: straight | click: suggest a line | Ctrl+click: point by point"

    @property
    def busy(self) -> bool:
        """Whether there is a line, drawn, suggested or looked for."""
        return super().busy or self._asked is not None or self._offer is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw; a drag cuts at its release."""
        match event.kind:
            case PointerKind.PRESS:
                self._press = Press(event)
            case PointerKind.MOVE if self._press is not None:
                if self._drag(self._press, event, host):
                    self._forget_offer()
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                self._end(press, event, host)
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
        self._forget_offer()
        super().cancel(host)
        return under_way

    def finish(self, host: Host) -> bool:
        """Cut along the line as it lies; along one that is still looked for, as soon as it is found."""
        if self._asked is not None:
            self._at_once = True
            return True
        offer, line = self._offer, self._pen.line
        if offer is None and len(line) < 2:
            return False
        self.cancel(host)
        if offer is not None:
            _cut(offer.label, offer.line, host)
        else:
            _cut(*_meant(host.session.labels, line, self._near), host)
        return True

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], tuple[int, list[Point]]]:
        """The block that would be cut, and where."""
        return partial(_meant, host.session.labels.copy(), line, self._near)

    def outlook(self, answer: tuple[int, list[Point]], host: Host) -> Outlook:
        """The block that would be cut, and how its line runs on."""
        label, line = answer
        return Outlook(f"cut {host.session.info(label).name}" if label else "cut nothing", line_path(line))

    def _end(self, press: Press, event: PointerEvent, host: Host) -> None:
        if press.drags and self._by_clicks:
            self._pen.rest()
        elif press.drags or (not event.ctrl and (self._offer is not None or self._asked is not None)):
            self.finish(host)
        elif self._by_clicks or event.ctrl or not self._ask(press.point, host):
            self._forget_offer()
            self._click(press.point, event.shift, host)

    def _forget_offer(self) -> None:
        self._offer = self._asked = None
        self._at_once = False

    def _ask(self, point: Point, host: Host) -> bool:
        """Look for a line in the block at a point; False if there is no block, and a line may be begun there."""
        label = host.session.label_at(*point)
        if label == 0:
            return False
        if not refuses(host, label) and knows_edges(host):
            self._asked = label, point
            _look_for_line(host, label, partial(self._take, host, label, point))
        return True

    def _take(self, host: Host, label: int, point: Point, line: list[Point] | None) -> None:
        if self._asked != (label, point):
            return
        at_once = self._at_once
        self._forget_offer()
        if line is not None:
            self._offer = _Offer(label, line)
            host.show_preview(Preview(line_path(line), dashed=True))
            if at_once:
                self.finish(host)
            return
        host.say(_nothing_found(host, label))


def suggested_cut(host: Host, label: int) -> None:
    """Cut a block where its depth and edges suggest it, as soon as that is known."""
    if refuses(host, label) or not knows_edges(host):
        return

    def take(line: list[Point] | None) -> None:
        if line is None:
            host.say(_nothing_found(host, label))
        else:
            _cut(label, line, host)

    _look_for_line(host, label, take)


def _nothing_found(host: Host, label: int) -> str:
    name = host.session.info(label).name
    return f"Nothing tells two surfaces in {name} apart. Drag a line across it with Split."


def _look_for_line(host: Host, label: int, take: Callable[[list[Point] | None], None]) -> None:
    session, aid = host.session, host.aid
    if aid is None:
        return
    frame, labels, strength = session.frame, session.labels.copy(), aid.strength
    host.work_out(lambda: suggest_split(frame, labels, label, strength), take)


def _meant(labels: Labels, line: list[Point], near: float) -> tuple[int, list[Point]]:
    """The block that a line is to cut, 0 for none, and the line as it runs on to its boundary.

    That is the block that it crosses most, of those that it parts as it is drawn; or else of all that it crosses. What
    is as thin as the line's trembling does not count as parted.
    """
    found = crossed(labels, line)
    for label, pixels in found.items():
        patch = split(labels, label, line, near=near)
        if patch is not None and is_thick(labels, label, patch, pixels):
            break
    else:
        label = next(iter(found), 0)
    return label, run_on(labels, label, line, near)


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
