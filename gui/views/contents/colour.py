"""The content "colour": the colour image with the blocks over it."""

from __future__ import annotations

from gui.views.overlay import BlockOverlay
from gui.views.view_cell import ViewCell

from .material import Material
from .painter import Painter


class ColourPainter(Painter):
    """Colour, the fills of the blocks, and stripes where depth is missing if they are to be seen."""

    uses = frozenset({"frame", "swipe", "runs"})

    def __init__(self, content: str, cell: ViewCell, material: Material, overlay: BlockOverlay) -> None:
        super().__init__(content, cell, material)
        self._overlay = overlay
        self._item = cell.view.place(overlay.new_item())
        # blocks of the two sides, where they are swiped and are others than the present ones
        self._sides = [cell.view.add_layer(1), cell.view.add_layer(1)]
        cell.view.shows_missing = True

    def draw(self) -> None:
        view, rgb = self.cell.view, self.material.rgb
        if rgb is None or view.image.image is not rgb:
            view.set_picture(rgb)
        self._draw_sides()

    def _draw_sides(self) -> None:
        column, blocks = self.material.swiped_at, self.material.side_blocks
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
        self._overlay.drop_item(self._item)
        for item in (self._item, *self._sides):
            self.cell.view.remove(item)
        self.cell.view.shows_missing = False
