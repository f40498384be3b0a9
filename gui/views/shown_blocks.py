"""The blocks over the pictures: fills, lines around them and names, drawn again only where they have changed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box, whole
from ilf.drawing.blocks import inner_points

from ..state.document import Document
from ..state.parts import EVERY_PART, Part
from ..state.workspace import Workspace
from .drawings import Argb, Pixels
from .image_view import ImageView, packed
from .screen_layers import BlockLines, Sampling
from .view_data import ViewData, colour_table

BLOCK_PARTS = Part.FRAME | Part.LABELS | Part.STROKE | Part.INFOS | Part.SELECTION


class ShownBlocks:
    """Draws the blocks of the current document, or of what stands in for it, over some views.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W), or None
        The label map as it is drawn; the document's may have changed since.
    colours : ndarray of uint8, shape (N + 1, 4)
        RGBA by label; alpha 0 hides a block.
    pixels : ndarray of uint32, shape (H, W), or None
        Colours of all fills; None if nothing is filled.
    """

    def __init__(self, workspace: Workspace, data: ViewData, views: Sequence[ImageView]) -> None:
        self._views = views
        self.labels: NDArray[np.int32] | None = None
        self.colours = np.zeros((1, 4), np.uint8)
        self.pixels: Pixels | None = None
        self._look = BlockLines(self.colours)
        self._lines: dict[Sampling, tuple[NDArray[np.int32], Argb]] = {}
        """Labels at the device pixels that show the frame, and the lines there; for views with the same sampling."""
        self._data = data
        self._drawn: NDArray[np.int32] | None = None
        """The label map that was drawn last, of which `labels` is a copy."""
        self._boxes: list[Box] = []
        """Where it has changed since."""
        self._opacity = 0.45
        self._shows_names = self._contours_only = False
        workspace.labels_changed.connect(self._boxes.append)
        for view in views:  # drawn when a view is painted: it may be resized several times before
            view.lines.find = partial(self._find_lines, view)

    def draw(self, parts: Part) -> None:
        """Draw what has changed: all if colours have, else the changed boxes, the selection and the names."""
        parts &= BLOCK_PARTS
        boxes, document, labels = self._boxes.copy(), self._data.document, self._data.labels
        self._boxes.clear()
        if document is None or labels is None:
            self._clear()
            return
        own = self.labels if labels is self._drawn else None
        is_other = own is None
        if own is None:
            own, boxes, top = labels.copy(), [], int(labels.max())
            self._drawn, self.labels = labels, own
        else:
            for box in boxes:
                own[box] = labels[box]
            top = max([len(self.colours) - 1, *(int(own[box].max()) for box in boxes)])
        former, self.colours = self.colours, colour_table(document, top)
        if is_other or self.pixels is None or not np.array_equal(self.colours[: len(former)], former):
            self._fill()
        else:
            self._fill_boxes(boxes, own, self.pixels)
        former_look = self._look
        self._look = BlockLines(self.colours, document.selected, sorted(document.state.to_check), self._contours_only)
        if is_other or not self._look.looks_like(former_look):
            self._drop_lines()
        else:
            self._draw_lines(own, boxes)
        if is_other or parts & ~(Part.STROKE | Part.SELECTION):
            self._write_names(document, own)

    def set_contours_only(self, on: bool) -> None:
        """Set whether blocks are drawn as coloured outlines without fill."""
        self._contours_only = on
        self._fill()
        self.draw(EVERY_PART)

    def set_opacity(self, opacity: float) -> None:
        """Set the opacity of the fills, 0-1."""
        self._opacity = min(max(opacity, 0.0), 1.0)
        self._fill()

    def show_names(self, on: bool) -> None:
        """Show or hide the blocks' names."""
        self._shows_names = on
        self.draw(EVERY_PART)

    def _clear(self) -> None:
        if self.labels is not None:
            self._drawn = self.labels = None
            self._fill()
            self._drop_lines()
            for view in self._views:
                view.write_names({}, {})

    def _drop_lines(self) -> None:
        self._lines.clear()
        for view in self._views:
            view.viewport().update()

    def _draw_lines(self, labels: NDArray[np.int32], boxes: Sequence[Box]) -> None:
        """Draw the lines that depend on changed boxes of the label map."""
        for sampling, (here, pixels) in self._lines.items():
            parts = [sampling.box_of(box) for box in boxes]
            for part in parts:
                here[part] = sampling.sample(labels, part)
            for part in parts:
                if all(span.start < span.stop for span in part):
                    place = sampling.on_screen(self._look.draw(here, pixels, part, sampling))
                    for view in self._views:
                        if view.sampling == sampling:
                            view.viewport().update(place)

    def _find_lines(self, view: ImageView) -> Argb | None:
        sampling, labels = view.sampling, self.labels
        if not view.has_lines or labels is None or labels.shape != sampling.frame[::-1]:
            return None
        if sampling not in self._lines:
            seen = {view.sampling for view in self._views if view.isVisible()}
            self._lines = {key: lines for key, lines in self._lines.items() if key in seen}
            everywhere = whole(sampling.shape)
            here, pixels = sampling.sample(labels, everywhere), np.zeros(sampling.shape, np.uint32)
            self._look.draw(here, pixels, everywhere, sampling)
            self._lines[sampling] = here, pixels
        return self._lines[sampling][1]

    def _fill(self) -> None:
        fills = self._fills()
        self.pixels = fills[self.labels] if self.labels is not None and fills.any() else None
        for view in self._views:
            view.fills.set_pixels(self.pixels)

    def _fill_boxes(self, boxes: Sequence[Box], labels: NDArray[np.int32], pixels: Pixels) -> None:
        fills = self._fills()
        for box in boxes:
            pixels[box] = fills[labels[box]]
            for view in self._views:
                view.fills.notify_change(box)

    def _fills(self) -> Pixels:
        """Colour of the fill by label."""
        fills = self.colours.astype(np.float32)
        fills[0] = 0
        fills[:, 3] *= 0.0 if self._contours_only else self._opacity
        return packed(fills.round().astype(np.uint8))

    def _write_names(self, document: Document, labels: NDArray[np.int32]) -> None:
        names = {label: document.info(label).name for label in document.counts()} if self._shows_names else {}
        points = inner_points(labels) if names else {}
        for view in self._views:
            view.write_names(names, points)
