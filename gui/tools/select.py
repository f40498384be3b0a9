"""The tool Select: selects blocks by clicks or by a selection rectangle."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Press, Tool


class SelectTool(Tool):
    """The tool Select. A click selects a block, with Ctrl adds or removes it, with Shift adds it; a drag pans.

    A drag with Shift selects the blocks of which more than half is inside the rectangle.
    """

    options = ("amount",)

    def __init__(self) -> None:
        self._press: Press | None = None

    @property
    def hint(self) -> str:
        """Hint: what a click or a drag would do."""
        return "Click: select | Ctrl+click: add or remove | Shift+drag: select by rectangle | drag: pan | wheel: zoom"

    @property
    def busy(self) -> bool:
        """Whether a selection rectangle is being drawn."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Select on press; the view handles the drag unless Shift starts a rectangle."""
        if event.kind is PointerKind.PRESS:
            if event.shift:
                self._press = Press(event)
                return True
            select_at((event.x, event.y), event, host)
        elif event.kind is PointerKind.MOVE and self._press is not None and self._press.follow(event):
            band = QPainterPath()
            band.addRect(self._press.box_to(event))
            host.show_preview(Preview(band, dashed=True))
        elif event.kind is PointerKind.RELEASE and self._press is not None:
            press = self._press
            self.cancel(host)
            if press.drags:
                add(_inside(press.box_to(event), host), host)
            else:
                select_at(press.point, event, host)
        return False

    def cancel(self, host: Host) -> bool:
        """Cancel the rectangle."""
        pending_work, self._press = self.busy, None
        host.show_preview(None)
        return pending_work


def select_at(point: Point, event: PointerEvent, host: Host) -> None:
    """Select only the block at a point; with Shift, add it; with Ctrl, add or remove it."""
    label = host.document.label_at(*point)
    chosen = list(host.document.selected)
    if not (event.ctrl or event.shift):
        host.select([label] if label else [])
    elif event.ctrl and label in chosen:
        host.select([other for other in chosen if other != label])
    else:
        add([label], host)


def add(labels: list[int], host: Host) -> None:
    """Add blocks to the selection; 0 is no block."""
    host.select(list(dict.fromkeys([*host.document.selected, *(label for label in labels if label)])))


def _inside(band: QRectF, host: Host) -> list[int]:
    """Return the blocks of which more than half is inside a rectangle, the largest part first."""
    labels = host.document.labels
    rows = slice(max(round(band.top()), 0), max(round(band.bottom()), 0))
    columns = slice(max(round(band.left()), 0), max(round(band.right()), 0))
    pixels = np.bincount(labels[rows, columns].ravel(), minlength=1)
    counts = host.document.counts()
    found = [int(label) for label in np.flatnonzero(pixels) if label and 2 * pixels[label] > counts[int(label)].pixels]
    return sorted(found, key=lambda label: -pixels[label])
