"""The tool Split: cuts a block along a line."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ilf.errors import InputError
from ilf.segmentation.editing.cutting import extend_to_boundary, split, suggest_split
from ilf.segmentation.editing.patches import Labels

from ..views.interaction import PointerEvent, Preview
from .base import Host, Point, Press, check_unlocked, crossed, edges_of, is_thick, line_path
from .line import Effect, LineTool


class SplitTool(LineTool):
    """Cut a block along a line.

    It is drawn across the block, freely or by clicks, or suggested by a click.
    """

    def __init__(self) -> None:
        super().__init__()
        self._suggestion: tuple[int, list[Point]] | None = None
        """The block to cut, and the line."""
        self._searched: tuple[int, Point] | None = None
        self._at_once = False

    @property
    def hint(self) -> str:
        """Hint: what a drag, a click or a key would do."""
        if self._searched is not None:
            return "Looking for a line between two surfaces… | Enter: cut as soon as it is found | Esc: cancel"
        if self._suggestion is not None:
            return "Click or Enter: cut along this line | drag: draw another | Esc: cancel"
        cut = "cut" if self._effect is None else self._effect[0]
        if self._by_clicks:
            return f"Click: next point | Shift: straight | Enter or double-click: {cut} | Backspace: remove last"
        idle = "Drag: cut along a line | Shift: straight | click: suggest a line | Ctrl+click: point by point"
        return self.release_hint or idle

    @property
    def busy(self) -> bool:
        """Whether there is a line: drawn, suggested or being searched."""
        return super().busy or self._searched is not None or self._suggestion is not None

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Draw another line than the suggested one."""
        draws = super()._drag(press, event, host)
        if draws:
            self._forget_suggestion()
        return draws

    def _double(self, host: Host) -> bool:
        """Cut along a line of clicks; the second of two quick clicks accepts the suggestion of the first."""
        if self._by_clicks:
            self.finish(host)
        return self._by_clicks

    def cancel(self, host: Host) -> None:
        """Cancel the line."""
        self._forget_suggestion()
        super().cancel(host)

    def finish(self, host: Host) -> bool:
        """Cut along the line; if a suggestion is still being searched, as soon as it is found."""
        if self._searched is not None:
            self._at_once = True
            return True
        offer, line = self._suggestion, self._pen.line
        if offer is None and len(line) < 2:
            return False
        self.cancel(host)
        _cut(*(offer or _cut_target(host.document.labels, line, self._near)), host)
        return True

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], tuple[int, list[Point]]]:
        """Return a function that computes which block would be cut, and where."""
        return partial(_cut_target, host.document.labels.copy(), line, self._near)

    def effect(self, answer: tuple[int, list[Point]], host: Host) -> Effect:
        """Return the block that would be cut, and the extended line."""
        label, line = answer
        return f"cut {host.document.info(label).name}" if label else "cut nothing", line_path(line)

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Cut after a drag; suggest a line, or add a point, after a click."""
        if press.drags and self._by_clicks:
            self._pen.rest()
        elif press.drags or (not event.ctrl and (self._suggestion is not None or self._searched is not None)):
            self.finish(host)
        elif self._by_clicks or event.ctrl or not self._ask(press.point, host):
            self._forget_suggestion()
            self._click(press.point, event.shift, host)

    def _forget_suggestion(self) -> None:
        self._suggestion = self._searched = None
        self._at_once = False

    def _ask(self, point: Point, host: Host) -> bool:
        """Start the search for a line in the block at a point; False if there is no block."""
        label = host.document.label_at(*point)
        if label == 0:
            return False
        find = _line_search(host, label)
        self._searched = label, point
        host.run_in_background(find, partial(self._take, host, label, point))
        return True

    def _take(self, host: Host, label: int, point: Point, line: list[Point] | None) -> None:
        if self._searched != (label, point):
            return
        at_once = self._at_once
        self._forget_suggestion()
        self._suggestion = label, _found(line, label, host)
        host.show_preview(Preview(line_path(self._suggestion[1]), dashed=True))
        if at_once:
            self.finish(host)


def cut_suggested(host: Host, label: int) -> None:
    """Cut a block along the line that its depth and edges suggest, as soon as it is found."""
    find = _line_search(host, label)
    host.run_in_background(find, lambda line: _cut(label, _found(line, label, host), host))


def _line_search(host: Host, label: int) -> Callable[[], list[Point] | None]:
    """Return a function that finds a line to cut a block along."""
    document = host.document
    check_unlocked(document, [label])
    return partial(suggest_split, document.frame, document.labels.copy(), label, edges_of(host).strength)


def _found(line: list[Point] | None, label: int, host: Host) -> list[Point]:
    if line is None:
        name = host.document.info(label).name
        raise InputError(f"No line between two surfaces was found in {name}. Drag a line across it with Split.")
    return line


def _cut_target(labels: Labels, line: list[Point], near: float) -> tuple[int, list[Point]]:
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
    return label, extend_to_boundary(labels, label, line, near)


def _cut(label: int, line: list[Point], host: Host) -> None:
    document = host.document
    if label == 0:
        raise InputError("The line crosses no block: draw it across one.")
    name = document.info(label).name
    check_unlocked(document, [label])
    patch = split(document.labels, label, line, document.locked, document.next_label())
    if host.commit(patch, f"Split {name}"):
        host.document.select([label])
    elif patch is None:
        raise InputError(f"The line does not divide {name}: draw it from boundary to boundary.")
