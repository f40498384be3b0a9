"""The tool Give: gives an existing piece of a block, or a part that a line cuts off, to another block."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ilf.errors import InputError
from ilf.segmentation.editing.cleaning import pixels_apart
from ilf.segmentation.editing.cutting import cut_off, piece_at
from ilf.segmentation.editing.painting import give
from ilf.segmentation.editing.patches import LabelPatch, Labels, values_at

from ..views.interaction import PointerEvent, Preview
from ..views.mask_paths import boundary_path
from .base import Host, Point, Press, around, check_unlocked, crossed, is_thick
from .line import LineTool, tell_if_apart


class GiveTool(LineTool):
    """Give pieces of other blocks to the selected block.

    A click gives the piece under the pointer; hovering shows it.

    A line drawn from one block through another cuts off a part of the second, and gives it to the first; to the
    selected block if the line starts in it or next to it.
    """

    def __init__(self) -> None:
        super().__init__()
        self._piece: NDArray[np.bool_] | None = None
        self._by_region = False

    @property
    def hint(self) -> str:
        """Hint: what a click or a drag would do."""
        idle = "Click: give this piece to the selected block | Ctrl: this region | Shift: select | drag: cut off a part"
        return self.release_hint or idle

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Cut a part off after a drag; give the piece after a click."""
        line = self._pen.line
        self.cancel(host)
        if press.drags:
            _cut_off(press.point, line, self._near, host)
        else:
            self._give(event, host)

    def _leave(self, host: Host) -> None:
        if self._press is None:
            self.cancel(host)

    def cancel(self, host: Host) -> None:
        """Cancel the line, and drop the shown piece, because the label map may have changed."""
        self._piece = None
        super().cancel(host)

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], tuple[LabelPatch | None, int]]:
        """Return a function that computes what the line would cut off."""
        start = line[0] if self._press is None else self._press.point
        takers = _receivers(host, start, self._near)
        find = partial(_find_cut, host.document.labels.copy(), takers, line, self._near)
        return lambda: (None, 0) if (cut := find()) is None else (cut.patch, cut.apart)

    def _give(self, event: PointerEvent, host: Host) -> None:
        document = host.document
        label = document.label_at(event.x, event.y)
        if event.shift or not document.selected:
            host.document.select([label] if label else [])
            if label:
                host.show_message(f"{document.info(label).name} is selected: it gets the pieces that you click.")
            return
        piece = self._at(event, host)
        if piece is not None:
            give_piece(host, piece, label)

    def _hover(self, event: PointerEvent, host: Host) -> None:
        """Show the piece under the pointer."""
        at, shown = np.array([[event.x, event.y]]), self._piece
        if shown is not None and event.ctrl == self._by_region and values_at(shown, at, beyond=0)[0]:
            return
        self._piece, self._by_region = self._at(event, host), event.ctrl
        host.show_preview(None if self._piece is None else Preview(boundary_path(self._piece)))

    def _at(self, event: PointerEvent, host: Host) -> NDArray[np.bool_] | None:
        """Return the piece under the pointer; None outside the frame."""
        edge_data = host.edge_data if event.ctrl else None
        piece = piece_at(host.document.labels, event.x, event.y, None if edge_data is None else edge_data.regions)
        return piece if piece.any() else None


@dataclass(frozen=True, eq=False)
class _Cut:
    """A part of the block `source` for the block `taker`; `apart` pixels of it are disconnected from the taker."""

    source: int
    taker: int
    patch: LabelPatch
    apart: int


def _receivers(host: Host, start: Point, near: float) -> tuple[list[int], list[int]]:
    """Return the blocks that a line from a point may be intended for, in this order; and those near its start."""
    document = host.document
    beside, chosen = around(document.labels, start, near), list(document.selected[:1])
    begun_in = [label for label in [document.label_at(*start)] if label]
    meant = chosen + begun_in if set(chosen) & set(beside) else begun_in + chosen
    return meant, beside


def _find_cut(labels: Labels, takers: Sequence[Sequence[int]], line: list[Point], near: float) -> _Cut | None:
    """Return what a line cuts off from a block for another, with the first list of takers that gives a cut.

    The source is the block that the line crosses most. Parts as thin as hand tremor, or disconnected from their taker,
    are used only if there is nothing else.
    """
    found = crossed(labels, line)
    for some in takers:
        cuts = []
        for taker in dict.fromkeys(some):
            for source in found:
                patch = cut_off(labels, source, line, taker, near=near)
                if patch is not None:
                    cuts.append(_Cut(source, taker, patch, pixels_apart(labels, patch, taker)))
        if cuts:
            return min(
                cuts, key=lambda cut: (not is_thick(labels, cut.source, cut.patch, found[cut.source]), cut.apart > 0)
            )
    return None


def _cut_off(start: Point, line: list[Point], near: float, host: Host) -> None:
    """Give a block the part that a line cuts off from another."""
    document = host.document
    takers = _receivers(host, start, near)
    cut = _find_cut(document.labels, takers, line, near)
    if cut is not None:
        check_unlocked(document, [cut.taker, cut.source])
        name = document.info(cut.taker).name
        host.commit(cut.patch, f"Give a part of {document.info(cut.source).name} to {name}", cut.taker)
        tell_if_apart(host, cut.taker, cut.apart)
    elif takers[0] and set(crossed(document.labels, line)) - set(takers[0][:1]):
        name = document.info(takers[0][0]).name
        raise InputError(f"The line cuts nothing off for {name}: draw it right across another block.")
    else:
        raise InputError("Start the line in the block that gets the part, and draw it right across another block.")


def give_piece(host: Host, piece: NDArray[np.bool_], source: int) -> None:
    """Give a piece of a block to the selected one, if neither is locked."""
    document = host.document
    label = document.selected[0]
    check_unlocked(document, [label, source])
    name = document.info(label).name
    if not host.commit(give(document.labels, piece, label, document.locked), f"Give a piece to {name}", label):
        raise InputError(f"This piece already belongs to {name}. Shift+click selects another block.")
