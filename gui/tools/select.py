"""The tool Select: selects blocks by clicks, by a box or by a stroke, and merges what a stroke crosses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from ilf._runtime.formatting import counted, grouped
from ilf.errors import InputError
from ilf.segmentation.editing.cleaning import merge, parts_touch

from ..state.document import Document
from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.mask_paths import boundary_path
from .base import Host, Point, Press, Tool, crossed, line_path


class SelectTool(Tool):
    """Select blocks.

    A click selects a block, with Ctrl adds or removes it, with Shift adds it; a drag pans.

    A drag with Shift selects the blocks of which more than half is inside the box, one with Ctrl those that the stroke
    crosses, and one with both merges these into the largest. All pieces of the blocks are outlined: of the one under
    the pointer, and of those that the drag would select or merge.
    """

    options = ("amount",)

    def __init__(self) -> None:
        self._act = "select"
        """What a drag does: "select" by a box, "add" by a stroke, or "merge" by one."""
        self._stroke: list[Point] = []
        self._found: list[int] = []
        """The blocks that are outlined."""
        self._outline = QPainterPath()
        self._effect = ""

    @property
    def hint(self) -> str:
        """Hint: what a click or a drag would do."""
        if self._effect:
            return f"Release: {self._effect} | Esc: cancel"
        return (
            "Click: select | Ctrl+click: add or remove | Shift+drag: select by box | Ctrl+drag: select what it crosses "
            "| Ctrl+Shift+drag: merge what it crosses | drag: pan"
        )

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Select on press, or on release with Shift or Ctrl; the view handles the drag without these."""
        press = self._press
        match event.kind:
            case PointerKind.PRESS if event.shift or event.ctrl:
                self._press, self._stroke, self._found = Press(event), [(event.x, event.y)], []
                self._act = ("merge" if event.shift else "add") if event.ctrl else "select"
                return True
            case PointerKind.PRESS:
                select_at((event.x, event.y), event, host)
            case PointerKind.MOVE if press is not None and press.follow(event):
                self._follow(press, event, host)
            case PointerKind.RELEASE if press is not None:
                act, found = self._act, self._found
                self.cancel(host)
                if not press.drags:
                    select_at(press.point, event, host)
                elif act == "merge":
                    merge_blocks(host, found)
                else:
                    add(found, host)
            case PointerKind.HOVER:
                label = host.document.label_at(event.x, event.y)
                self._show([label] if label else [], None, host)
            case PointerKind.LEAVE if press is None:
                self._show([], None, host)
        return False

    def cancel(self, host: Host) -> None:
        """Cancel the drag, and drop the outline, because the label map may have changed."""
        self._press, self._effect = None, ""
        self._found, self._outline = [], QPainterPath()
        host.show_preview(None)

    def _follow(self, press: Press, event: PointerEvent, host: Host) -> None:
        document = host.document
        if self._act == "select":
            drawn = QPainterPath()
            drawn.addRect(press.box_to(event))
            found = _inside(press.box_to(event), host)
        else:
            self._stroke.append((event.x, event.y))
            drawn = line_path(self._stroke)
            found = list(dict.fromkeys([*self._found, *crossed(document.labels, self._stroke[-2:])]))
        if self._act == "merge":
            free = [label for label in found if label not in document.locked]
            self._effect = f"merge {_count_text(document, free)}"
            left_out = _locked_text(document, found)
            self._effect += f" | {left_out}" if left_out else ""
        else:
            chosen = list(dict.fromkeys([*document.selected, *found]))
            self._effect = f"{self._act} {_count_text(document, found)}, {len(chosen)} selected then"
        self._show(found, drawn, host)

    def _show(self, found: list[int], drawn: QPainterPath | None, host: Host) -> None:
        """Outline blocks with all their pieces, and show the box or stroke."""
        document = host.document
        if found != self._found:
            merges = drawn is not None and self._act == "merge"
            mask = np.isin(document.labels, [one for one in found if not merges or one not in document.locked])
            self._found, self._outline = found, boundary_path(mask)
        if drawn is None and not found:
            host.show_preview(None)
            return
        host.show_preview(Preview(drawn or QPainterPath(), dashed=self._act == "select", line_preview=self._outline))


def select_at(point: Point, event: PointerEvent, host: Host) -> None:
    """Select only the block at a point; with Shift, add it; with Ctrl, add or remove it."""
    label = host.document.label_at(*point)
    chosen = list(host.document.selected)
    if not (event.ctrl or event.shift):
        host.document.select([label] if label else [])
    elif event.ctrl and label in chosen:
        host.document.select([other for other in chosen if other != label])
    else:
        add([label], host)


def add(labels: list[int], host: Host) -> None:
    """Add blocks to the selection; 0 is no block."""
    host.document.select(list(dict.fromkeys([*host.document.selected, *(label for label in labels if label)])))


def merge_blocks(host: Host, labels: Sequence[int]) -> None:
    """Merge blocks into the largest of them as one undo step, and select it; locked ones are left out, with a word."""
    document = host.document
    counts = document.counts()
    free = [label for label in labels if label in counts and label not in document.locked]
    free.sort(key=lambda label: -counts[label].pixels)
    left_out = _locked_text(document, labels)
    if len(free) < 2:
        few = "Two or more unlocked blocks are needed to merge: select them, or Ctrl+Shift+drag across them."
        raise InputError(f"{left_out}. {few}" if left_out else few)
    apart = not parts_touch(document.labels, free)
    if host.commit(merge(document.labels, free, document.locked), f"Merge {len(free)} blocks", free[0]):
        host.document.select(free[:1])
        if left_out:
            host.show_message(f"{left_out}.")
        if apart:
            name = document.info(free[0]).name
            host.show_message(f"{name} now has parts that do not touch: each part is completed separately.")


def _locked_text(document: Document, labels: Sequence[int]) -> str:
    names = [document.info(label).name for label in labels if label in document.locked]
    return f"{', '.join(names)} left out: locked" if names else ""


def _count_text(document: Document, labels: Sequence[int]) -> str:
    counts = document.counts()
    pixels = sum(counts[label].pixels for label in labels)
    return f"{counted(len(labels), 'block')}, {grouped(pixels)} px"


def _inside(band: QRectF, host: Host) -> list[int]:
    """Return the blocks of which more than half is inside a rectangle, the largest part first."""
    rows = slice(max(round(band.top()), 0), max(round(band.bottom()), 0))
    columns = slice(max(round(band.left()), 0), max(round(band.right()), 0))
    pixels = np.bincount(host.document.labels[rows, columns].ravel(), minlength=1)
    counts = host.document.counts()
    found = [int(label) for label in np.flatnonzero(pixels) if label and 2 * pixels[label] > counts[int(label)].pixels]
    return sorted(found, key=lambda label: -pixels[label])
