"""Giving a piece of one block to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gui.tools.base import Host, Tool
from gui.views.overlay import boundary_path
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import give
from ilf.ebs.pieces import piece_at


class GiveTool(Tool):
    """A click gives the piece under the pointer to the chosen block; hovering shows the piece."""

    def __init__(self) -> None:
        self._piece: NDArray[np.bool_] | None = None
        self._by_region = False

    @property
    def hint(self) -> str:
        """What a click would do."""
        return "Click: give this piece to the chosen block | Ctrl+click: this region | Shift+click: choose the block"

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Show the piece, or give it."""
        match event.kind:
            case PointerKind.PRESS:
                self._press(event, host)
            case PointerKind.LEAVE:
                self.cancel(host)
            case PointerKind.HOVER | PointerKind.MOVE:
                self._show(event, host)
        return event.kind is not PointerKind.DOUBLE

    def cancel(self, host: Host) -> bool:
        """Forget the piece that is shown, as the label map may be another; nothing is ever under way."""
        self._piece = None
        host.show_preview(None)
        return False

    def _press(self, event: PointerEvent, host: Host) -> None:
        session = host.session
        label = session.label_at(event.x, event.y)
        if event.shift or not session.selected:
            host.select([label] if label else [])
            if label:
                host.say(f"{session.info(label).name} gets the pieces that you click now.")
            return
        piece = self._at(event, host)
        if piece is None:
            return
        self.cancel(host)
        give_piece(host, piece, label)

    def _show(self, event: PointerEvent, host: Host) -> None:
        shown = self._piece
        row, column = int(event.y // 1), int(event.x // 1)
        inside = shown is not None and 0 <= row < shown.shape[0] and 0 <= column < shown.shape[1]
        if inside and shown is not None and shown[row, column] and event.ctrl == self._by_region:
            return
        self._piece, self._by_region = self._at(event, host), event.ctrl
        host.show_preview(None if self._piece is None else piece_preview(self._piece))

    def _at(self, event: PointerEvent, host: Host) -> NDArray[np.bool_] | None:
        """The piece under the pointer; None off the frame."""
        guide = host.guide if event.ctrl else None
        piece = piece_at(host.session.labels, event.x, event.y, None if guide is None else guide.regions)
        return piece if piece.any() else None


def give_piece(host: Host, piece: NDArray[np.bool_], source: int) -> None:
    """Give a piece of a block to the chosen one, if neither is locked."""
    session = host.session
    label = session.selected[0]
    for one in (label, source):
        if one in session.locked:
            host.say(f"{session.info(one).name} is locked. Unlock it in the table of blocks.")
            return
    name = session.info(label).name
    if not host.commit(give(session.labels, piece, label, session.locked), f"Give a piece to {name}"):
        host.say(f"This is {name} already. Shift+click chooses another block.")


def piece_preview(piece: NDArray[np.bool_]) -> Preview:
    """Outline of a piece, bool (H, W)."""
    rows = np.flatnonzero(piece.any(axis=1))
    columns = np.flatnonzero(piece[rows[0] : rows[-1] + 1].any(axis=0))
    box = piece[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    path = boundary_path(box, int(columns[0]), int(rows[0]))
    return Preview(path)
