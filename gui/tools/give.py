"""Giving a piece of one block to another: one that is there, or one that a line cuts off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gui.tools.base import Host, Point, Press, refuses
from gui.tools.crossing import crossed
from gui.tools.line import LineTool
from gui.views.overlay import boundary_path
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview
from ilf.ebs.edit import LabelPatch, cut_off, give
from ilf.ebs.pieces import piece_at

_THIN = 3
"""Pixels per pixel of the line that cuts it off up to which a part may be but its trembling."""


class GiveTool(LineTool):
    """A click gives the piece under the pointer to the chosen block; hovering shows the piece.

    A line drawn from one block through another cuts a part off that, and gives it to the one that it begins in.
    """

    def __init__(self) -> None:
        super().__init__()
        self._piece: NDArray[np.bool_] | None = None
        self._by_region = False

    @property
    def hint(self) -> str:
        """What a click or a drag would do."""
        return "Click: give this piece to the chosen block | Ctrl: this region | Shift: choose | drag: cut a part off"

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Show the piece, or give it; draw while the button is down, and cut at its release."""
        match event.kind:
            case PointerKind.PRESS:
                self._press = Press(event)
            case PointerKind.MOVE if self._press is not None:
                self._drag(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                press, line = self._press, self._pen.line
                self.cancel(host)
                if press.drags:
                    _cut_off(press.point, line, host)
                else:
                    self._give(event, host)
            case PointerKind.LEAVE if self._press is None:
                self.cancel(host)
            case PointerKind.HOVER:
                self._show_piece(event, host)
        return event.kind is not PointerKind.DOUBLE

    def cancel(self, host: Host) -> bool:
        """Drop the line, and forget the piece that is shown, as the label map may be another."""
        self._piece = None
        return super().cancel(host)

    def _give(self, event: PointerEvent, host: Host) -> None:
        session = host.session
        label = session.label_at(event.x, event.y)
        if event.shift or not session.selected:
            host.select([label] if label else [])
            if label:
                host.say(f"{session.info(label).name} gets the pieces that you click now.")
            return
        piece = self._at(event, host)
        if piece is not None:
            give_piece(host, piece, label)

    def _show_piece(self, event: PointerEvent, host: Host) -> None:
        shown = self._piece
        row, column = int(event.y // 1), int(event.x // 1)
        inside = shown is not None and 0 <= row < shown.shape[0] and 0 <= column < shown.shape[1]
        if inside and shown is not None and shown[row, column] and event.ctrl == self._by_region:
            return
        self._piece, self._by_region = self._at(event, host), event.ctrl
        host.show_preview(None if self._piece is None else piece_preview(self._piece))

    def _at(self, event: PointerEvent, host: Host) -> NDArray[np.bool_] | None:
        """The piece under the pointer; None off the frame."""
        aid = host.aid if event.ctrl else None
        piece = piece_at(host.session.labels, event.x, event.y, None if aid is None else aid.regions)
        return piece if piece.any() else None


def _cut_off(start: Point, line: list[Point], host: Host) -> None:
    """Give the block that a line begins in what it cuts off from another, the one that it crosses most if from several.

    What is as thin as the line's trembling is meant only if there is nothing else. If the line cuts off nothing but of
    that block itself, the chosen one gets it.
    """
    session = host.session
    takers = dict.fromkeys([session.label_at(*start), *session.selected[:1]])
    found = crossed(session.labels, line)
    ways = [(source, label) for label in takers if label for source in found if source != label]
    if not ways:
        host.say("Begin the line in the block that is to get a part, and draw it right across another.")
        return
    cuts = {way: cut_off(session.labels, way[0], line, way[1]) for way in ways}
    parts = [(way, patch) for way, patch in cuts.items() if patch is not None]
    if not parts:
        name = session.info(ways[0][1]).name
        host.say(f"The line cuts nothing off for {name}: draw it right across another block.")
        return
    (source, label), patch = next((part for part in parts if _thick(*part, found)), parts[0])
    if not refuses(host, label) and not refuses(host, source):
        host.commit(patch, f"Give a part of {session.info(source).name} to {session.info(label).name}")


def _thick(way: tuple[int, int], patch: LabelPatch, crossed_pixels: dict[int, int]) -> bool:
    return int(np.count_nonzero(patch.before != patch.after)) > _THIN * crossed_pixels[way[0]]


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
