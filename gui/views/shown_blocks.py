"""The blocks over the pictures: fills, lines around them and names, drawn again only where they have changed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box
from ilf.drawing.blocks import inner_points

from ..state.document import Document
from ..state.parts import EVERY_PART, Part
from ..state.workspace import Workspace
from .image_view import ImageView
from .pixel_items import Pixels, packed
from .screen_layers import BlockLines, ScreenLayers
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
        self._layers = ScreenLayers(views)
        self.labels: NDArray[np.int32] | None = None
        self.colours = np.zeros((1, 4), np.uint8)
        self.pixels: Pixels | None = None
        self._data = data
        self._drawn: NDArray[np.int32] | None = None
        """The label map that was drawn last, of which `labels` is a copy."""
        self._boxes: list[Box] = []
        """Where it has changed since."""
        self._opacity = 0.45
        self._shows_names = self._contours_only = False
        workspace.labels_changed.connect(self._boxes.append)

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
        lines = BlockLines(self.colours, document.selected, sorted(document.state.to_check), self._contours_only)
        self._layers.show_blocks(own, lines, boxes)
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
            self._layers.show_blocks(None, BlockLines(self.colours))
            for view in self._views:
                view.write_names({}, {})

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
