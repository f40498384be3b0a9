"""The content "colour": the colour image with the blocks over it."""

from __future__ import annotations

from gui.views.overlay import BlockOverlay
from gui.views.view_cell import ViewCell

from .material import Material
from .painter import Painter


class ColourPainter(Painter):
    """Colour, the fills of the blocks, and stripes where depth is missing if they are to be seen."""

    uses = frozenset({"frame"})

    def __init__(self, content: str, cell: ViewCell, material: Material, overlay: BlockOverlay) -> None:
        super().__init__(content, cell, material)
        self._overlay = overlay
        self._item = cell.view.place(overlay.new_item())
        cell.view.shows_missing = True

    def draw(self) -> None:
        view, rgb = self.cell.view, self.material.rgb
        if rgb is None or view.image.image is not rgb:
            view.set_picture(rgb)

    def leave(self) -> None:
        self._overlay.drop_item(self._item)
        self.cell.view.remove(self._item)
        self.cell.view.shows_missing = False
