"""Painters over the colour image: colour with blocks, masks, edge strength."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from ilf.data.label_map import Box
from ilf.drawing.blocks import marked_picture
from ilf.drawing.colours import sample, to_indices

from ..base.theme import Colours
from .colours import strength_table
from .painter import EVERYWHERE, Depth, Mask, Material, Painter, number_at
from .pixel_items import BlockOverlay
from .view_cell import ViewCell


class ColourPainter(Painter):
    """Painter of colour, block fills, and optional stripes where depth is missing."""

    uses = frozenset({"frame", "swipe", "runs"})

    def __init__(self, content: str, cell: ViewCell, material: Material, overlay: BlockOverlay) -> None:
        super().__init__(content, cell, material)
        self._overlay = overlay
        self._item = cell.view.place(overlay.new_item())
        # blocks of the two sides, if divided and different from the current ones
        self._sides = [cell.view.add_layer(1), cell.view.add_layer(1)]
        cell.view.shows_missing = True

    def draw(self) -> None:
        view, rgb = self.cell.view, self.material.rgb
        if rgb is None or view.image.image is not rgb:
            view.set_picture(rgb)
        self._draw_sides()

    def _draw_sides(self) -> None:
        column, blocks = self.material.swipe_column, self.material.side_blocks
        width = 0 if self.material.rgb is None else self.material.rgb.shape[1]
        spans = [(0, width), (width, width)] if column is None else [(0, column), (column, width)]
        own = [0, width]
        for index, (item, given, span) in enumerate(zip(self._sides, blocks, spans, strict=True)):
            if column is None or given is None:
                item.clear()
                continue
            item.set_pixels(self._overlay.fills_of(*given))
            item.set_span(span)
            own[index] = column
        self._item.set_span((own[0], own[1]) if own != [0, width] else None)

    def leave(self) -> None:
        self._overlay.remove_item(self._item)
        for item in (self._item, *self._sides):
            self.cell.view.remove(item)
        self.cell.view.shows_missing = False


# Extrapolated pixels, invalid ones and those from neighbours over the dimmed colour image.

_COLOURS = {"extrapolated": (90, 200, 255), "invalid_mask": (255, 144, 32), "from_neighbours": (120, 220, 110)}


class MaskPainter(Painter):
    """Painter of a mask (extrapolated, invalid or from neighbours), with its share of the frame."""

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        self.uses = frozenset({"frame", "result" if content == "extrapolated" else content})
        super().__init__(content, cell, material)
        self._drawn: Mask | None = None

    def draw(self) -> None:
        mask, rgb = self._mask(), self.material.rgb
        if mask is None or rgb is None:
            self._drawn = None
            self.cell.strip.set_text("")
            self.cell.set_legend([])
            self.show_placeholder(self._reason())
        elif mask is not self._drawn:
            self._drawn = mask
            colour = _COLOURS[self.content]
            share = np.count_nonzero(mask) / mask.size
            self.cell.view.set_picture(marked_picture(rgb, mask, colour))
            self.cell.strip.set_text(f"{share:.1%} of the frame")
            if self.content != "invalid_mask":  # invalid depth has stripes, which have a legend already
                self.cell.set_legend([(QBrush(QColor(*colour)), self.content.replace("_", " "))])

    def _mask(self) -> Mask | None:
        if self.content == "invalid_mask":
            return self.material.invalid_mask
        if self.content == "from_neighbours":
            return self.material.from_neighbours
        layer = self.material.layer("result")
        return None if layer is None else layer.extrapolated

    def _reason(self) -> str:
        if self.content == "invalid_mask":
            return "No invalid depth"
        if self.content == "from_neighbours":
            return "No depth of neighbours is used"
        return self.material.no_result if self.material.result is None else "Nothing is extrapolated"

    def leave(self) -> None:
        self.cell.strip.set_text("")


# Edge strength, from which blocks are extracted, and creases, if the detector finds them.


class StrengthPainter(Painter):
    """Painter of the edge strength, or crease strength, of every pixel, 0-1."""

    uses = frozenset({"edges"})
    _drawn: Depth | None = None

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self.cell.set_legend([])

    def draw(self) -> None:
        edges = self.material.edges
        strength = None if edges is None else edges.crease if self.content == "creases" else edges.strength
        if strength is None:
            self._drawn = None
            self.show_placeholder(self._message)
        elif strength is not self._drawn:
            self._drawn = strength
            table = strength_table()
            self.cell.bar.set_table(table)
            self.cell.bar.set_levels((0.0, 1.0))
            self.cell.view.set_picture(to_indices(strength, 0.0, 1.0), table)

    @property
    def _message(self) -> str:
        if self.material.edges is not None:
            return "Only the detector rgbd finds creases"
        return "Finding edges\N{HORIZONTAL ELLIPSIS}" if self.material.rgb is not None else ""

    def value_at(self, x: int, y: int) -> float | None:
        return number_at(self._drawn, x, y)

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        return None if self._drawn is None else sample(self._drawn[where])
