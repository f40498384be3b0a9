"""The tool Refine edge: the brush marks a band along a border, and only the band is divided anew."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ilf.segmentation.editing.painting import Stroke, brush_stroke
from ilf.segmentation.editing.patches import LabelPatch
from ilf.segmentation.editing.refining import refine_borders

from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.pixel_items import boundary_path
from .base import Host, Point, Tool, edges_ready, warn_if_any_locked
from .brush import Swept, brush_preview
from .line_preview import LinePreview, preview_of_patch


class RefineTool(Tool):
    """The tool Refine edge. A stroke along a border decides the covered pixels by edges, colour and depth, as one undo
    step; a dashed outline shows the pixels that would change their block."""

    options = ("brush",)
    guided = True

    def __init__(self) -> None:
        self._swept: Swept | None = None
        self._last: Point = 0.0, 0.0
        self._effect: LinePreview | None = None
        self._decide: Callable[[], None] | None = None
        """Decides the band of a stroke that was released, until this is done."""

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        if self._effect is not None:
            return f"Release: {self._effect.text} | Esc: cancel"
        return "Drag along a border: place it anew within the brush | [ ] or Ctrl+wheel: brush size"

    @property
    def busy(self) -> bool:
        """Whether a stroke is in progress, or is being decided."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Cover pixels while the button is down; decide them on release."""
        self._show(event, host)
        if event.kind is PointerKind.PRESS:
            if self._decide is not None:
                self._decide()
            if edges_ready(host):
                self._swept, self._last = Swept(host.document.labels.shape), (event.x, event.y)
                self._sweep(self._swept, event, host)
        elif self._swept is not None and self._decide is None:
            if event.kind is PointerKind.MOVE:
                self._sweep(self._swept, event, host)
            elif event.kind is PointerKind.RELEASE:
                self._end(self._swept, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> bool:
        """Cancel the stroke."""
        pending_work, self._swept, self._effect, self._decide = self.busy, None, None, None
        host.show_preview(None)
        return pending_work

    def _sweep(self, swept: Swept, event: PointerEvent, host: Host) -> None:
        point = event.x, event.y
        stroke = brush_stroke(swept.mask.shape, [self._last, point], host.options.brush_radius)
        self._last = point
        if stroke is not None:
            swept.add(stroke)
        self._show(event, host)
        find = self._find(swept, host)
        if find is not None:
            host.run_in_background(find, partial(self._take_effect, swept, event, host))

    def _take_effect(self, swept: Swept, event: PointerEvent, host: Host, patch: LabelPatch | None) -> None:
        if swept is self._swept:
            self._effect = preview_of_patch(host.document, patch)
            self._show(event, host)

    def _end(self, swept: Swept, host: Host) -> None:
        find = self._find(swept, host)
        if find is None:
            self.cancel(host)
            return
        self._decide = lambda: self._commit(swept, host, find())
        host.run_in_background(find, partial(self._commit, swept, host))

    def _commit(self, swept: Swept, host: Host, patch: LabelPatch | None) -> None:
        if swept is not self._swept:
            return
        self.cancel(host)
        if host.commit(patch, "Refine edge"):
            return
        inside = np.unique(host.document.labels[swept.mask]).tolist()
        if warn_if_any_locked(host, inside):
            return
        if len(inside) < 2:
            host.show_message("There is no border under the brush: paint along a border between two blocks.")
        else:
            host.show_message("The border stays: no better one was found under the brush.")

    def _find(self, swept: Swept, host: Host) -> Callable[[], LabelPatch | None] | None:
        """Return a function that divides the band; None if it is outside the frame."""
        edge_data, band, document = host.edge_data, swept.stroke, host.document
        if edge_data is None or band is None:
            return None
        band = Stroke(band.box, band.mask.copy())
        return partial(
            refine_borders, edge_data.frame, edge_data.snapper.evidence, document.labels.copy(), band, document.locked
        )

    def _show(self, event: PointerEvent, host: Host) -> None:
        if event.kind is PointerKind.LEAVE and not self.busy:
            host.show_preview(None)
            return
        line = brush_preview(event, host).line
        band = None if self._swept is None else self._swept.stroke
        if band is not None:
            line.addPath(boundary_path(band.mask, band.box[1].start, band.box[0].start))
        host.show_preview(Preview(line, line_preview=None if self._effect is None else self._effect.path))
