"""The tool Smart select: selects a surface or object by clicks, a box or strokes, for a new block or to change one."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from ilf.data.blocks import cropped
from ilf.data.frame import RGBDFrame
from ilf.errors import InputError
from ilf.segmentation.editing.cleaning import pixels_apart
from ilf.segmentation.editing.painting import erase, give
from ilf.segmentation.editing.patches import LabelPatch, patch_between
from ilf.segmentation.selection import select_region

from ..state.document import Document
from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.mask_paths import boundary_path, filled_path
from .base import Host, Point, Press, Tool, check_unlocked, line_path
from .brush import Mask
from .line import tell_if_apart

_CROSS = 4.0
"""Half the width of the cross at a point that was taken away [screen pixels]."""


class _Mark(NamedTuple):
    """What is added or taken away: the points of a click or a stroke, or two corners of a box; and its steps from part
    to object."""

    points: tuple[Point, ...]
    inside: bool = True
    steps: int = 0
    is_box: bool = False


class SmartSelectTool(Tool):
    """Select a surface or object by clicks, strokes or a box: a new block, or a change of the selected one.

    Clicks add what is under them to the selection, with Ctrl they take it away. A drag draws
    a box, with Shift a stroke, which acts like a click. Ctrl+wheel steps to smaller and larger regions, after a click
    as after a box, or says why not. Enter makes the selection a block.

    The first click starts a new block, also inside the selected one; with Shift or Ctrl the selection starts as the
    selected block, to which clicks add or, with Ctrl, from which they take away, and Enter changes the block. The
    preview shows what a click would change; it is hatched where a block changes.
    """

    options = ("to_no_block",)
    wheel = True

    def __init__(self) -> None:
        self._stroke: list[Point] = []
        """The stroke in progress, if it is one."""
        self._marks: tuple[_Mark, ...] = ()
        """What determines the selection, in order; a box is the first."""
        self._steps = 0
        """The steps of the next click, while there is none."""
        self._label = 0
        """The block that the selection changes; 0 for a new one."""
        self._name = ""
        self._mask: Mask | None = None
        """The selection; None while it is being computed."""
        self._next: Mask | None = None
        """What a click at the pointer would change."""
        self._finishes = False
        """Whether Enter was pressed while the selection was being computed."""
        self._before_steps: tuple[tuple[_Mark, ...], Mask] | None = None
        """What was selected before the wheel was turned, and with what, until its effect is known."""
        self._pixel = 1.0

    @property
    def hint(self) -> str:
        """Hint: what a click, a drag or a key would do."""
        if self._marks:
            end = f"change {self._name}" if self._label else "make it a block"
            return (
                f"Enter: {end} | click or Shift+drag: add | with Ctrl: take away | "
                f"wrong size: Ctrl+wheel or [ ], or drag a box | Backspace: remove last | Esc: cancel"
            )
        return (
            "Click or drag a box: new block | Shift: add to the selected block | Ctrl: take away from it | "
            "Ctrl+wheel or [ ]: smaller or larger"
        )

    @property
    def busy(self) -> bool:
        """Whether there is a selection, or the button is pressed."""
        return self._press is not None or bool(self._marks)

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Add a click, a stroke or a box on release; step with the wheel; otherwise show what a click would change."""
        self._pixel = event.pixel
        match event.kind:
            case PointerKind.PRESS:
                self._press, self._next = Press(event), None
                self._stroke = [self._press.point] if event.shift or event.opposite else []
            case PointerKind.MOVE if self._press is not None and self._press.follow(event):
                self._draw(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                self._add(press, event, host)
            case PointerKind.WHEEL:
                self._step(event, host)
            case PointerKind.HOVER if self._mask is not None or not self._marks:
                self._look_ahead(event, host)
            case PointerKind.LEAVE if self._press is None:
                self._next = None
                self._show(host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> None:
        """Drop the selection."""
        self._press = self._mask = self._next = self._before_steps = None
        self._marks, self._steps, self._finishes = (), 0, False
        host.show_preview(None)

    def undo_last(self, host: Host) -> bool:
        """Remove the last click, or else the box."""
        if not self._marks:
            return False
        self._marks = self._marks[:-1]
        if self._marks:
            self._update(host)
        else:
            self.cancel(host)
        return True

    def finish(self, host: Host) -> bool:
        """Make the selection a block, or change the block with which it started."""
        if not self._marks:
            return False
        mask, self._finishes = self._mask, self._mask is None
        if mask is None:
            return True
        document = host.document
        label = self._label or document.next_label()
        check_unlocked(document, [label])
        name = document.info(label).name
        before = document.labels.copy()
        patch = _change(document, mask, label, host.options.to_no_block)
        self.cancel(host)
        done = host.commit(patch, f"Smart select {name}", label)
        if done is None:
            raise InputError(f"The selection changes no pixels of {name}: it is equal, or they are in locked blocks.")
        host.document.select([label])
        remedy = " Click without Shift to make a new block."
        tell_if_apart(host, label, pixels_apart(before, done, label), remedy)
        return True

    def _draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Show the box or the stroke in progress."""
        if self._stroke:
            self._stroke.append((event.x, event.y))
            host.show_preview(Preview(line_path(self._stroke)))
            return
        band = QPainterPath()
        band.addRect(press.box_to(event))
        host.show_preview(Preview(band, dashed=True))

    def _add(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Add a click or a stroke, or start anew with a box."""
        height, width = host.document.labels.shape
        is_box = press.drags and not self._stroke
        label = self._label if self._marks else 0 if is_box else _start(event, host)
        if not self._marks and label in host.document.locked:
            self._show(host)
            check_unlocked(host.document, [label])
        if is_box:
            box = press.box_to(event).intersected(QRectF(0, 0, width, height))
            corners = box.topLeft().toTuple(), box.bottomRight().toTuple()
            self._marks, self._steps = () if box.isEmpty() else (_Mark(corners, is_box=True),), 0
        else:
            drawn = self._stroke if press.drags else [(event.x, event.y)]
            points = tuple((x, y) for x, y in drawn if 0 <= x < width and 0 <= y < height)
            if event.opposite and not self._marks and not label:
                host.show_message(
                    "There is nothing to take away yet: click what you want to select, or select a block."
                )
            elif points:
                self._marks = self._with(points, inside=not event.opposite)
                self._steps = self._steps if event.opposite else 0
        self._stroke, self._label, self._name = [], label, host.document.info(label).name if label else ""
        if self._marks:
            self._update(host)
        else:
            self._show(host)

    def _step(self, event: PointerEvent, host: Host) -> None:
        """Step to a larger or smaller region."""
        inside = [number for number, mark in enumerate(self._marks) if mark.inside]
        if not self._marks:
            self._steps += event.steps
            self._look_ahead(event, host)
            return
        if not inside:
            raise InputError("Sizes belong to what a click or a box adds: click what you want to add first.")
        before = self._before_steps
        if before is None and self._mask is not None:
            before = self._marks, self._mask
        marks = list(self._marks)
        marks[inside[-1]] = marks[inside[-1]]._replace(steps=marks[inside[-1]].steps + event.steps)
        self._marks = tuple(marks)
        self._update(host)
        self._before_steps = before

    def _with(self, points: tuple[Point, ...], inside: bool) -> tuple[_Mark, ...]:
        """The marks with another click or stroke."""
        return *self._marks, _Mark(points, inside, self._steps if inside else 0)

    def _tell_if_same(self, mask: Mask, host: Host) -> None:
        """Say why the wheel has changed nothing, and forget its steps, so that the next one back has an effect."""
        before, self._before_steps = self._before_steps, None
        if before is None or not np.array_equal(before[1], mask):
            return
        former, larger = (sum(mark.steps for mark in marks) for marks in (before[0], self._marks))
        self._marks = before[0]
        if larger > former:
            host.show_message("There is no larger region here: click what else belongs to it, or drag a box around it.")
        elif larger < former:
            host.show_message("There is no smaller region here: take parts away with Ctrl+click, or drag a box.")

    def _update(self, host: Host) -> None:
        """Compute the selection in the background."""
        self._mask = self._next = self._before_steps = None
        find = _search(self._marks, self._label, host)
        host.run_in_background(find, partial(self._take, host, self._marks))

    def _take(self, host: Host, marks: tuple[_Mark, ...], mask: Mask) -> None:
        if marks is not self._marks or self._press is not None:
            return
        self._mask = mask
        self._tell_if_same(mask, host)
        self._show(host)
        if self._finishes:
            self.finish(host)

    def _look_ahead(self, event: PointerEvent, host: Host) -> None:
        """Compute what a click would change, in the background."""
        height, width = host.document.labels.shape
        label = self._label if self._marks else _start(event, host)
        inside_frame = 0 <= event.x < width and 0 <= event.y < height
        if not inside_frame:
            self._next = None
            self._show(host)
            return
        before = self._mask if self._mask is not None else host.document.labels == label if label else None
        inside = not event.opposite or not (self._marks or label)  # Ctrl may be held for the wheel
        after = _search(self._with(((event.x, event.y),), inside), label, host)
        find = partial(_difference, before, after)
        host.run_in_background(find, partial(self._take_next, host, self._marks))

    def _take_next(self, host: Host, marks: tuple[_Mark, ...], mask: Mask) -> None:
        if marks is self._marks and self._press is None:
            self._next = mask
            self._show(host)

    def _show(self, host: Host) -> None:
        """Show the outline of the selection, dashed that of a further click's change, a square at each click inside,
        the strokes, and a cross at each click outside."""
        half, corners = _CROSS * self._pixel, list[Point]()
        path, ahead = (QPainterPath() if mask is None else boundary_path(mask) for mask in (self._mask, self._next))
        changed = QPainterPath()
        if self._label and self._mask is not None:
            changed = filled_path(self._mask ^ (host.document.labels == self._label))
        for mark in self._marks:
            if mark.is_box:
                continue
            (x, y), *further = mark.points
            if further:
                path.addPath(line_path(mark.points))
            if mark.inside:
                corners.append((x, y))
                continue
            for slope in (-1, 1):
                path.moveTo(x - half, y - slope * half)
                path.lineTo(x + half, y + slope * half)
        seen = not path.isEmpty() or not ahead.isEmpty() or corners
        host.show_preview(Preview(path, corners, area=changed, line_preview=ahead) if seen else None)


def _start(event: PointerEvent, host: Host) -> int:
    """The block that a first click changes; 0 for a new one."""
    selected = host.document.selected
    return selected[0] if selected and (event.shift or event.opposite) else 0


def _search(marks: Sequence[_Mark], label: int, host: Host) -> partial[Mask]:
    """Return a function that computes the selection."""
    return partial(_selected, host.document.frame, marks, host.document.labels == label if label else None)


def _selected(frame: RGBDFrame, marks: Sequence[_Mark], start: Mask | None) -> Mask:
    """What a box selects, and then clicks add or take away."""
    if marks and marks[0].is_box:
        box, *marks = marks
        start = select_region(frame, (), box=(*box.points[0], *box.points[1]), steps=box.steps, start=start)
    if start is not None and not marks:
        return start
    inside = [mark for mark in marks if mark.inside]
    outside = [mark.points for mark in marks if not mark.inside]
    return select_region(
        frame, [mark.points for mark in inside], outside, steps=[mark.steps for mark in inside], start=start
    )


def _difference(before: Mask | None, find: partial[Mask]) -> Mask:
    """The pixels that a selection changes."""
    after = find()
    return after if before is None else after ^ before


def _change(document: Document, mask: Mask, label: int, to_no_block: bool) -> LabelPatch | None:
    """The change that makes a mask a block: its pixels join the block, others leave it, to neighbours or no block."""
    labels = document.labels.copy()
    added = give(labels, mask, label, document.locked)
    if added is not None:
        added.apply(labels)
    if (left := cropped((labels == label) & ~mask)) is not None:
        frame = None if to_no_block else document.frame
        removed = erase(labels, left, label, document.locked, frame)
        if removed is not None:
            removed.apply(labels)
    return patch_between(document.labels, labels)
