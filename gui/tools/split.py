"""The tool Split: cuts a block along a line."""

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
    """The tool Split: draw a line across a block, freely or by clicks, or accept the line that a click suggests."""

    def __init__(self) -> None:
        super().__init__()
        self._offer: _Offer | None = None
        self._asked: tuple[int, Point] | None = None
        self._at_once = False

    @property
    def hint(self) -> str:
        """Hint: what a drag, a click or a key would do."""
        if self._asked is not None:
            return "Looking for a line between two surfaces… | Enter: cut as soon as it is found | Esc: cancel"
        if self._offer is not None:
            return "Click or Enter: cut along this line | drag: draw another | Esc: cancel"
        cut = "cut" if self._outlook is None else self._outlook.text
        if self._by_clicks:
            return f"Click: next point | Shift: straight | Enter or double-click: {cut} | Backspace: remove last"
        if self._outlook is not None:
            return f"Release: {cut} | Shift: straight | Esc: cancel"
        return "Drag: cut along a line | Shift: straight | click: suggest a line | Ctrl+click: point by point"

    @property
    def busy(self) -> bool:
        """Whether there is a line: drawn, suggested or being searched."""
        return super().busy or self._asked is not None or self._offer is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw; a drag cuts on release."""
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
                if not self._by_clicks:  # the second of two quick clicks accepts the suggestion of the first
                    return False
                self.finish(host)
        return True

    def cancel(self, host: Host) -> bool:
        """Cancel the line."""
        under_way = self.busy
        self._forget_offer()
        super().cancel(host)
        return under_way

    def finish(self, host: Host) -> bool:
        """Cut along the line; if a suggestion is still being searched, as soon as it is found."""
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
        """Return a function that computes which block would be cut, and where."""
        return partial(_meant, host.session.labels.copy(), line, self._near)

    def outlook(self, answer: tuple[int, list[Point]], host: Host) -> Outlook:
        """Return the preview: the block that would be cut, and the extended line."""
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
        """Start the search for a line in the block at a point; False if there is no block."""
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
    """Cut a block along the line that its depth and edges suggest, as soon as it is found."""
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
    return f"No line between two surfaces was found in {name}. Drag a line across it with Split."


def _look_for_line(host: Host, label: int, take: Callable[[list[Point] | None], None]) -> None:
    session, aid = host.session, host.aid
    if aid is None:
        return
    frame, labels, strength = session.frame, session.labels.copy(), aid.strength
    host.work_out(lambda: suggest_split(frame, labels, label, strength), take)


def _meant(labels: Labels, line: list[Point], near: float) -> tuple[int, list[Point]]:
    """Return the block that a line cuts, 0 for none, and the line extended to the block's boundary.

    It is the block that the line crosses most, of those that it divides; or else of all that it crosses. Parts as thin
    as hand tremor do not count.
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
        host.say("The line crosses no block: draw it across one.")
        return
    name = session.info(label).name
    if refuses(host, label):
        return
    if host.commit(split(session.labels, label, line, session.locked, session.next_label()), f"Split {name}"):
        host.select([label])
    else:
        host.say(f"The line does not divide {name}: draw it from boundary to boundary.")
