"""The expected error of what was filled, in logarithmic colours; what was measured is marked.

What nothing vouches for has stripes, which lie over the picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from gui.theme import Colours
from gui.views.changes import changed_box
from gui.views.colour_maps import error_table
from gui.views.items import mix
from gui.views.ranges import Levels
from gui.views.view_cell import ViewCell
from ilf.drawing.levels import log_indices, robust_error_levels, sample

from .material import Depth, Material
from .painter import NO_RESULT, Painter, levels_of, mark_table, number_at

_MM = np.float32(1000)
_LEAST_MM = 0.01
_ESTIMATING = "Estimating\N{HORIZONTAL ELLIPSIS}"


class ExpectedErrorPainter(Painter):
    """Neither the depth in nor the error is changed in place."""

    uses = frozenset({"distrust", "expected-error", "levels", "moment"})
    range_kind = "expected"
    unit = "mm"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        super().__init__(content, cell, material)
        self._measured = cell.view.add_layer(-0.5)
        cell.view.shows_unvouched = True
        self._drawn: tuple[Depth, Depth, Levels] | None = None
        self._marks = mark_table(QColor())
        self._table = error_table()
        cell.bar.set_table(self._table)

    def draw(self) -> None:
        depth, error, drawn = self.material.depth_in, self.material.expected, self._drawn
        outdated = error is not None and self.material.error_is_outdated
        of_present = "of the present result" if error is not None and self.material.moment else ""
        self.cell.strip.set_text("of the result before" if outdated else of_present)
        if depth is None or error is None:
            self._drawn = None
            self._measured.clear()
            self.show_nothing(_ESTIMATING if self.material.error_is_outdated else NO_RESULT)
            return
        few = sample(error) * _MM
        low, high = levels_of(self.material, "expected", lambda: robust_error_levels(few), lambda: error * _MM)
        levels = max(low, _LEAST_MM), max(high, 2 * max(low, _LEAST_MM))
        self._drawn = depth, error, levels
        if drawn is not None and drawn[0] is depth and drawn[2] == levels:
            box = changed_box(drawn[1], error)
            if box is not None:
                self.cell.view.image.update_indices(box, log_indices(error[box], levels))
            return
        self._measured.set_indices(np.isfinite(depth).view(np.uint8), self._marks)
        self.cell.view.set_picture(log_indices(error, levels), self._table)
        self.cell.bar.set_levels(levels, logarithmic=True)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        measured = mix(colours.background, colours.text, 0.2 if colours.is_dark else 0.14)
        self._marks = mark_table(measured)
        self.cell.set_legend([(QBrush(measured), "measured"), (hatch, "missing")])
        self._drawn = None

    def value_at(self, x: int, y: int) -> float | None:
        return None if self._drawn is None else number_at(self._drawn[1], x, y, 1000.0)

    def values(self) -> NDArray[np.floating] | None:
        return None if self._drawn is None else sample(self._drawn[1]) * _MM

    def leave(self) -> None:
        self.cell.view.remove(self._measured)
        self.cell.view.shows_unvouched = False
