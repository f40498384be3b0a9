"""The edges that the blocks go by, and creases, where the detector tells of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush

from gui.theme import Colours
from gui.views.colour_maps import strength_table
from ilf.drawing.levels import sample, to_indices

from .material import Depth
from .painter import Painter, number_at


class StrengthPainter(Painter):
    """How much every pixel looks like a boundary, or like a crease, 0-1."""

    uses = frozenset({"edges"})
    _drawn: Depth | None = None

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self.cell.set_legend([])

    def draw(self) -> None:
        edges = self.material.edges
        strength = None if edges is None else edges.crease if self.content == "creases" else edges.strength
        if strength is None:
            self._drawn = None
            self.show_nothing(self._message)
        elif strength is not self._drawn:
            self._drawn = strength
            table = strength_table()
            self.cell.bar.set_table(table)
            self.cell.bar.set_levels((0.0, 1.0))
            self.cell.view.set_picture(to_indices(strength, 0.0, 1.0), table)

    @property
    def _message(self) -> str:
        if self.material.edges is not None:
            return "Only the detector rgbd tells of creases"
        return "Finding edges\N{HORIZONTAL ELLIPSIS}" if self.material.rgb is not None else ""

    def value_at(self, x: int, y: int) -> float | None:
        return number_at(self._drawn, x, y)

    def values(self) -> NDArray[np.floating] | None:
        return None if self._drawn is None else sample(self._drawn)
