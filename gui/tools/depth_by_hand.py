"""The tool Depth by hand: paints depth where none was measured, and proposes surfaces to continue into a hole."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

from ilf.completion.continuation import continue_plane, nearer_or_farther
from ilf.errors import InputError
from ilf.segmentation.editing.patches import unlocked_pixels, values_at

from ..state.document import Document
from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.mask_paths import boundary_path
from .base import Host, check_unlocked
from .brush import Mask, StrokeTool, brush_preview

Depth = NDArray[np.float32]

_NO_DEPTH = "No depth is set yet: Ctrl+click picks one from the image, or type it in the tool bar."
_NOT_MISSING = (
    "Nothing is missing here: depth by hand counts only where depth is missing. Mark the measured depth invalid first."
)
_NO_BLOCK = "No block has missing depth here: depth by hand counts in blocks only."
_NOT_SELECTED = "The selected blocks have no missing depth here. Clear the selection (Esc) to paint in all blocks."


class DepthByHandTool(StrokeTool):
    """State depth where it is missing: paint it, fill a hole, or continue a surface.

    A drag paints the set depth on missing depth of the selected blocks, or of all if none is selected; Shift erases,
    Ctrl+click picks the depth under the pointer.

    A proposal, such as a continued plane, is shown in images and point cloud until Enter takes it; meanwhile a drag
    limits it to what the brush covers.
    """

    options = ("brush", "hand_depth")

    def __init__(self) -> None:
        super().__init__()
        self._erases = False
        self._surface: Depth | None = None
        """The proposed surface, whole."""
        self._about = self._step = ""
        """What it is, for the hint; and the undo step that takes it."""
        self._kept: Mask | None = None
        """Pixels that it is limited to; None for all."""
        self._outline = QPainterPath()

    @property
    def hint(self) -> str:
        """Hint: what a click, a drag or a key would do."""
        if self._surface is not None:
            return f"Enter: take | Esc: drop | drag: only under the brush | {self._about}"
        return "Drag: paint the depth | Ctrl+click: pick a depth | Shift+drag: erase | [ ] or Ctrl+wheel: brush size"

    @property
    def busy(self) -> bool:
        """Whether a stroke is in progress or a surface is proposed."""
        return super().busy or self._surface is not None

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Pick a depth with Ctrl; else start a stroke."""
        if event.opposite:
            pick_depth(host, event.x, event.y)
            return False
        self._erases = event.shift and self._surface is None
        if self._surface is None and not self._erases and host.options.hand_depth <= 0:
            raise InputError(_NO_DEPTH)
        return True

    def apply(self, swept: Mask, host: Host) -> None:
        """Limit the proposal to the stroke, or paint, or erase."""
        document = host.document
        if self._surface is not None:
            kept = swept if self._kept is None else self._kept | swept
            if not np.isfinite(self._surface[kept]).any():
                raise InputError("The proposed surface has no depth under this stroke.")
            self._kept = kept
            self._show(host)
        elif self._erases:
            _remove(document, swept & _selected(document))
        else:
            missing = swept & document.frame.missing
            if not missing.any():
                raise InputError(_NOT_MISSING)
            wanted = missing & _selected(document) & (document.labels > 0)
            if not wanted.any():
                raise InputError(_NOT_SELECTED if document.selected and document.labels[missing].any() else _NO_BLOCK)
            _state(document, _constant(host), wanted, "Paint depth")

    def cancel(self, host: Host) -> None:
        """Cancel the stroke and drop the proposal."""
        self._surface = self._kept = None
        super().cancel(host)
        host.document.propose(None)

    def finish(self, host: Host) -> bool:
        """Take the proposal as depth by hand."""
        if self._surface is None:
            return False
        proposal = self._proposal
        self.cancel(host)
        _state(host.document, proposal, np.isfinite(proposal), self._step)
        return True

    def fill(self, host: Host) -> None:
        """State the set depth at all missing depth of the selected blocks."""
        if host.options.hand_depth <= 0:
            raise InputError(_NO_DEPTH)
        _state(host.document, _constant(host), _hole_of(host.document), "Fill with depth")

    def erase(self, host: Host) -> None:
        """Remove depth by hand from the selected blocks, or everywhere if none is selected."""
        _remove(host.document, _selected(host.document))

    def propose_plane(self, host: Host) -> None:
        """Propose the plane of the known depth in the rectangle, or else in the selected blocks, for their holes."""
        document, hole = host.document, _hole_of(host.document)
        source = np.isin(document.labels, document.selected)
        if document.state.looked.region is not None:
            source = np.zeros_like(source)
            source[document.state.looked.region] = True
        where = "in the rectangle" if document.state.looked.region is not None else "in the selected blocks"

        def find() -> tuple[Depth, str]:
            found, share = continue_plane(document.frame.depth, source, hole)
            return found, f"Plane through {share:.0%} of the known depth {where}"

        self._find(host, find, "Continue plane")

    def propose_surface(self, host: Host, nearer: bool) -> None:
        """Propose the nearer or the farther of the surfaces around the holes of the selected blocks."""
        document, hole = host.document, _hole_of(host.document)
        text, labels = f"{'Nearer' if nearer else 'Farther'} surface", document.labels.copy()
        self._find(host, lambda: (nearer_or_farther(document.frame.depth, labels, hole, nearer), text), text)

    def _find(self, host: Host, find: Callable[[], tuple[Depth, str]], step: str) -> None:
        """Find a surface and what it is in the background, and propose it."""
        self.cancel(host)
        host.run_in_background(find, partial(self._take, host, step))

    def _take(self, host: Host, step: str, found: tuple[Depth, str]) -> None:
        (self._surface, self._about), self._step, self._kept = found, step, None
        self._show(host)

    def _show(self, host: Host) -> None:
        """Show the proposal, and the outline of its larger parts: those of thousands of single pixels are slow."""
        proposal = self._proposal
        host.document.propose(proposal)
        large = cv2.morphologyEx(np.isfinite(proposal).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
        self._outline = boundary_path(large)
        host.show_preview(Preview(self._outline, dashed=True))

    def show_brush(self, event: PointerEvent, host: Host) -> None:
        if self._surface is None:
            super().show_brush(event, host)
            return
        area = self._trail(host.options.brush_radius) if self._swept is not None else None
        path = QPainterPath() if event.kind is PointerKind.LEAVE else brush_preview(event, host).line
        path.addPath(self._outline)
        host.show_preview(Preview(path, area=area, dashed=True))

    @property
    def _proposal(self) -> Depth:
        assert self._surface is not None
        return self._surface if self._kept is None else np.where(self._kept, self._surface, np.float32(np.nan))


def _state(document: Document, depth: Depth, where: Mask, text: str) -> None:
    """State depth, except in locked blocks."""
    free = where & unlocked_pixels(document.labels, document.locked)
    if not free.any():
        check_unlocked(document, np.unique(document.labels[where]).tolist())
    document.set_by_hand(depth, free, text)


def _remove(document: Document, where: Mask) -> None:
    """Remove depth by hand, except in locked blocks."""
    free = where & unlocked_pixels(document.labels, document.locked)
    if not document.set_by_hand(np.full(where.shape, np.nan, np.float32), free, "Remove depth by hand"):
        raise InputError("There is no depth by hand here that can be removed.")


def _selected(document: Document) -> Mask:
    """Return the pixels of the selected blocks, bool (H, W); all pixels if none is selected."""
    if not document.selected:
        return np.ones(document.labels.shape, bool)
    return np.isin(document.labels, document.selected)


def _constant(host: Host) -> Depth:
    """Return the set depth at every pixel."""
    return np.full(host.document.frame.shape, host.options.hand_depth, np.float32)


def _hole_of(document: Document) -> Mask:
    """Return the missing depth of the selected blocks, bool (H, W); raise InputError if there is none."""
    if not document.selected:
        raise InputError("Select the block with the hole first.")
    hole: Mask = document.frame.missing & np.isin(document.labels, document.selected)
    if not hole.any():
        raise InputError("The selected blocks have no missing depth.")
    return hole


def pick_depth(host: Host, x: float, y: float) -> None:
    """Set the depth to paint to that at image coordinates, completed or measured."""
    completed = host.document.current_depth()
    shown = host.document.frame.depth if completed is None else completed
    depth = float(values_at(shown, np.array([[x, y]]), beyond=0)[0])
    if not depth > 0:
        raise InputError("There is no depth to pick here.")
    host.set_option("hand_depth", depth)
