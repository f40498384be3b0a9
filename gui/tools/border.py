"""Tools that redraw a border between blocks or outline a block."""

from __future__ import annotations

import math
from collections.abc import Callable

from ilf.errors import InputError
from ilf.segmentation.editing.borders import redraw_border
from ilf.segmentation.editing.cleaning import pixels_apart
from ilf.segmentation.editing.painting import assign_outline
from ilf.segmentation.editing.patches import LabelPatch, Labels

from ..state.document import Document
from ..views.interaction import PointerEvent
from .adjusting import AdjustableLine, AdjustableTool
from .base import Host, Point, Press, check_unlocked, locked_text
from .line import tell_if_apart
from .select import select_at


class BorderTool(AdjustableTool):
    """Draw a border between two blocks anew; the blocks on both sides follow.

    A click selects a block.
    """

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        idle = "Drag: redraw a border | Shift: straight | click: select a block"
        return self.adjust_hint or self.release_hint or idle

    def draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Change the blocks on both sides of the line, or select the block under a click."""
        line = AdjustableLine.of(self._pen.stretches, (), self.slack)
        self.cancel(host)
        if press.drags:
            self.apply(line, "Redraw border", host)
        else:
            select_at(press.point, event, host)

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], tuple[LabelPatch | None]]:
        """Return a function that computes the change by the line."""
        labels = host.document.labels.copy()
        return lambda: (redraw_border(labels, line),)

    def change(self, labels: Labels, line: list[Point], document: Document) -> LabelPatch | None:
        """Return the change by the line."""
        return redraw_border(labels, line, document.locked)

    def explain(self, line: list[Point], document: Document) -> str:
        """Return a sentence why the line moves no border."""
        swept = redraw_border(document.labels, line)
        locked = "" if swept is None else locked_text(document, swept.touched)
        return locked or (
            "The line moves no border: draw it next to the border that it replaces. To cut off a part, use Give."
        )


# Outlining a block.

_NEAR = 8
"""Distance from the first corner within which a click closes the outline [screen pixels]."""


class OutlineTool(AdjustableTool):
    """Outline pixels to make them a new block, or to add them to the selected one.

    The outline is drawn by a drag or by clicks.
    """

    def __init__(self) -> None:
        super().__init__()
        self._joins = False

    @property
    def hint(self) -> str:
        """Hint: what a drag, a click or a key would do."""
        close = "close" if self._effect is None else self._effect[0]
        if self._by_clicks and not self.adjust_hint:
            return f"Click: next corner | Shift: straight | Enter or double-click: {close} | Backspace: remove last"
        idle = "Drag or click corners: make the inside a new block | Ctrl: add it to the selected block"
        return self.adjust_hint or self.release_hint or idle

    def _double(self, host: Host) -> bool:
        """Close the outline; it was begun by the first of the two clicks."""
        if self._applied is not None:
            return False
        if len(self._pen.corners) > 2:
            self.finish(host)
        return True

    def finish(self, host: Host) -> bool:
        """Close the outline; with fewer than three corners it stays open. Then end its adjustment."""
        if not self._pen.down:
            return super().finish(host)
        line = self._pen.line
        if len(line) < 3:
            raise InputError("An outline needs at least three corners.")
        closing = self._pen.reach(line[0], False, self._snap(host))
        outline = AdjustableLine.of(self._pen.stretches, [line[-1], *closing[1:-1], line[0]], self.slack)
        self.cancel(host)
        document = host.document
        self.label = self._target(host) or document.next_label()
        self.apply(outline, f"Outline {document.info(self.label).name}", host)
        return True

    def change(self, labels: Labels, line: list[Point], document: Document) -> LabelPatch | None:
        """Return the change by the outline."""
        return assign_outline(labels, line, self.label, document.locked)

    def explain(self, line: list[Point], document: Document) -> str:
        """Return a sentence that the outline adds no pixels."""
        name = document.info(self.label).name
        return f"The outline adds no pixels to {name}: they belong to it already, or to locked blocks."

    def after_change(self, before: Labels, patch: LabelPatch, host: Host) -> None:
        """Select the block; show a message if pixels are disconnected from the rest of it."""
        host.document.select([self.label])
        remedy = " Start an outline without Ctrl to make a new block."
        tell_if_apart(host, self.label, pixels_apart(before, patch, self.label), remedy)

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], tuple[LabelPatch | None, int]]:
        """Return a function that computes the change by the outline and the number of disconnected pixels."""
        document = host.document
        labels, locked, label = document.labels.copy(), document.locked, self._target(host) or document.next_label()

        def find() -> tuple[LabelPatch | None, int]:
            patch = assign_outline(labels, line, label, locked)
            return patch, pixels_apart(labels, patch, label)

        return find

    def _target(self, host: Host) -> int:
        """Return the block that gets the inside: the selected one if it has no pixels yet; 0 for a new one."""
        chosen = host.document.selected[:1]
        return chosen[0] if chosen and (self._joins or chosen[0] not in host.document.counts()) else 0

    def _begin(self, event: PointerEvent, host: Host) -> bool:
        """Start an outline or its next corner; a press at the first corner closes it."""
        if not self._pen.down:
            super()._begin(event, host)
            if self._grip is None:
                self._joins = event.opposite
                check_unlocked(host.document, [self._target(host)])
            return True
        corners = self._pen.corners
        closes = len(corners) > 2 and math.dist(corners[0], (event.x, event.y)) <= _NEAR * event.pixel
        if closes:
            self.finish(host)
        return not closes

    def draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Add a corner; a drag closes the outline."""
        if not press.drags:
            self._click(press.point, event.shift, host)
        elif self._by_clicks:
            self._pen.rest()
        else:
            try:
                self.finish(host)
            finally:
                if self._pen.down:  # too short to be closed
                    self.cancel(host)
