"""What is guessed, and what is distrusted, over the dimmed colour image."""

from __future__ import annotations

import numpy as np
from PySide6.QtGui import QBrush, QColor

from gui.views.view_cell import ViewCell
from ilf.drawing.marked import marked_picture

from .material import Mask, Material
from .painter import NO_RESULT, Painter

_COLOURS = {"guessed": (90, 200, 255), "distrusted": (255, 144, 32)}


class MaskPainter(Painter):
    """Pixels of which one thing holds, with their share of the frame."""

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        self.uses = frozenset({"frame", "distrust" if content == "distrusted" else "result"})
        super().__init__(content, cell, material)
        self._drawn: Mask | None = None

    def draw(self) -> None:
        mask, rgb = self._mask(), self.material.rgb
        if mask is None or rgb is None:
            self._drawn = None
            self.cell.strip.set_text("")
            self.cell.set_legend([])
            self.show_nothing(self._reason())
        elif mask is not self._drawn:
            self._drawn = mask
            colour = _COLOURS[self.content]
            share = np.count_nonzero(mask) / mask.size
            self.cell.view.set_picture(marked_picture(rgb, mask, colour))
            self.cell.strip.set_text(f"{share:.1%} of the frame")
            if self.content == "guessed":  # what is distrusted has its stripes, and is in the legend for them
                self.cell.set_legend([(QBrush(QColor(*colour)), self.content)])

    def _mask(self) -> Mask | None:
        if self.content == "distrusted":
            return self.material.distrusted
        layer = self.material.layer("result")
        return None if layer is None else layer.guessed

    def _reason(self) -> str:
        if self.content == "distrusted":
            return "Nothing is distrusted"
        return NO_RESULT if self.material.result is None else "Nothing is guessed"

    def leave(self) -> None:
        self.cell.strip.set_text("")
