"""The tool Refine edge: the brush marks a band along a border, and only the band is divided anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ilf.data.blocks import cropped
from ilf.segmentation.editing.patches import LabelPatch
from ilf.segmentation.editing.refining import refine_borders

from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.mask_paths import boundary_path
from .base import Host, Point, edges_of, locked_text
from .brush import Mask, StrokeTool, brush_preview
from .line import Effect, effect_of


class RefineTool(StrokeTool):
    """Brush along a border: only the pixels under the brush are divided anew, by edges, colour and depth.

    A stroke is one undo step; a dashed outline shows the pixels that would change their block.
    """

    guided = True

    def __init__(self) -> None:
        super().__init__()
        self._effect: Effect | None = None
        self._decide: Callable[[], None] | None = None
        """Decides the band of a stroke that was released, until this is done."""
        self._at: PointerEvent | None = None
        """Where the brush was last shown."""

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        if self._effect is not None:
            return f"Release: {self._effect[0]} | Esc: cancel"
        return "Drag along a border: place it anew within the brush | [ ] or Ctrl+wheel: brush size"

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Decide the last stroke, and begin another if the edges are known."""
        if self._decide is not None:
            self._decide()
        self._at = event
        edges_of(host)
        return True

    def cancel(self, host: Host) -> None:
        """Cancel the stroke."""
        self._effect = self._decide = None
        super().cancel(host)

    def _sweep(self, swept: Mask, point: Point, host: Host) -> None:
        super()._sweep(swept, point, host)
        find = self._find(swept, host)
        if find is not None:
            host.run_in_background(find, partial(self._take_effect, swept, host))

    def _take_effect(self, swept: Mask, host: Host, patch: LabelPatch | None) -> None:
        if swept is self._swept and self._at is not None:
            self._effect = effect_of(host.document, patch)
            self.show_brush(self._at, host)

    def apply(self, swept: Mask, host: Host) -> None:
        """Decide the stroke in the background; meanwhile it is shown."""
        find = self._find(swept, host)
        if find is None:
            self.cancel(host)
            return
        self._swept = swept
        self._decide = lambda: self._commit(swept, host, find())
        host.run_in_background(find, partial(self._commit, swept, host))

    def _commit(self, swept: Mask, host: Host, patch: LabelPatch | None) -> None:
        if swept is not self._swept:
            return
        self.cancel(host)
        if host.commit(patch, "Refine edge"):
            return
        inside = np.unique(host.document.labels[swept]).tolist()
        text = "There is no border under the brush: paint along a border between two blocks."
        if len(inside) > 1:
            text = "The border stays: no better one was found under the brush."
        host.show_message(locked_text(host.document, inside) or text)

    def _find(self, swept: Mask, host: Host) -> Callable[[], LabelPatch | None] | None:
        """Return a function that divides the band; None if it is outside the frame."""
        edge_data, band, document = host.edge_data, cropped(swept), host.document
        if edge_data is None or band is None:
            return None
        return partial(
            refine_borders, edge_data.frame, edge_data.evidence, document.labels.copy(), band, document.locked
        )

    def show_brush(self, event: PointerEvent, host: Host) -> None:
        self._at = event
        if event.kind is PointerKind.LEAVE and not self.busy:
            host.show_preview(None)
            return
        line = brush_preview(event, host).line
        if self._swept is not None:
            line.addPath(boundary_path(self._swept))
        host.show_preview(Preview(line, line_preview=None if self._effect is None else self._effect[1]))
