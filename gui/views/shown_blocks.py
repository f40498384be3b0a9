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
from .pixel_items import BlockOverlay
from .screen_layers import BlockLines, ScreenLayers
from .view_data import ViewData, colour_table

BLOCK_PARTS = Part.FRAME | Part.LABELS | Part.STROKE | Part.INFOS | Part.SELECTION


class ShownBlocks:
    """Draws the blocks of the current document, or of what stands in for it, over some views."""

    def __init__(self, workspace: Workspace, data: ViewData) -> None:
        self.overlay = BlockOverlay(1)
        self.layers = ScreenLayers()
        self.views: Sequence[ImageView] = ()
        """The views that names are written in."""
        self._data = data
        self._drawn: NDArray[np.int32] | None = None
        """The label map that was drawn last."""
        self._boxes: list[Box] = []
        """Where it has changed since."""
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
        is_other = labels is not self._drawn
        known = 0 if is_other else len(self.overlay.colours) - 1
        changed = [labels] if is_other else [labels[box] for box in boxes]
        table = colour_table(document, max([known, *(int(part.max()) for part in changed)]))
        if is_other:
            self.overlay.set_blocks(labels, table)
        else:
            self.overlay.set_colours(table)
            for box in boxes:
                self.overlay.update_region(box, labels[box])
        self._drawn = labels
        lines = BlockLines(table, document.selected, sorted(document.state.to_check), self._contours_only)
        self.layers.show_blocks(self.overlay.labels, lines, boxes)
        if is_other or parts & ~(Part.STROKE | Part.SELECTION):
            self._write_names(document)

    def set_contours_only(self, on: bool) -> None:
        """Set whether blocks are drawn as coloured outlines without fill."""
        self._contours_only = on
        self.overlay.set_filled(not on)
        self.draw(EVERY_PART)

    def show_names(self, on: bool) -> None:
        """Show or hide the blocks' names."""
        self._shows_names = on
        self.draw(EVERY_PART)

    def _clear(self) -> None:
        if self._drawn is not None:
            self._drawn = None
            self.overlay.clear()
            self.layers.show_blocks(None, BlockLines(self.overlay.colours))
            for view in self.views:
                view.write_names({}, {})

    def _write_names(self, document: Document) -> None:
        labels = self.overlay.labels
        names = {label: document.info(label).name for label in document.counts()} if self._shows_names else {}
        points = inner_points(labels) if labels is not None and names else {}
        for view in self.views:
            view.write_names(names, points)
