"""Depth in metres: depth in, the result, a run's, the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from gui.theme import Colours
from gui.views.changes import changed_box, union
from gui.views.items import hatch_brush
from gui.views.ranges import Levels
from gui.views.view_cell import ViewCell
from ilf.drawing.levels import sample, to_indices

from .material import Depth, Layer, Mask, Material
from .names import EARLIER, INTERPOLATED, RUNS, TITLES, capital, short_title
from .painter import NO_GUIDE, NO_RESULT, Painter, number_at

_STRIPE = QColor(255, 255, 255, 190)
_STALE = QColor(140, 146, 140)


class DepthPainter(Painter):
    """Depth; what is missing shows the hatch, what is guessed is striped, what is stale is greyed."""

    range_kind = "depth"
    unit = "m"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        # distrust leaves depth in as it was measured
        self._own_parts = frozenset({"frame" if content == "depth-in" else _PARTS.get(content, "runs"), "levels"})
        if content == "result":
            self._own_parts |= {"swipe", "runs"}
        self.uses = self._own_parts
        super().__init__(content, cell, material)
        # from below: the hatch of what is missing, guesses, stripes over them, and the rest of the depth
        self._guesses = cell.view.add_layer(-0.8)
        self._stripes = cell.view.add_hatch(-0.6)
        self._stripes.setVisible(False)
        self._swatch = QBrush()
        self._hatch = QBrush()
        # what is drawn: copies, since what is given may be changed in place
        self._depth: Depth | None = None
        self._stale: Mask = np.zeros((0, 0), bool)
        self._guessed: Mask | None = None
        self._levels: Levels = (0.0, 0.0)
        self._table = np.zeros((256, 4), np.uint8)

    @property
    def title(self) -> str:
        looked_at = self.content
        if looked_at == "result" and self.material.looks_at_a:
            looked_at = self.material.sides[0]
        if looked_at == "result" and self.material.swiped_at is not None:
            first, second = (short_title(side, self.material.names) for side in self.material.sides)
            return f"A: {first} | B: {second}"
        return TITLES.get(looked_at) or capital(short_title(looked_at, self.material.names))

    def draw(self) -> None:
        if self.content == "result":  # swiped, or while side A stands in for it, it may be any depth
            others = self.material.swiped_at is not None or self.material.looks_at_a
            sides = {_PARTS.get(side, "runs") for side in self.material.sides} if others else set()
            self.uses = self._own_parts | sides
        run = self.material.run(self.content)
        self.cell.strip.set_title(self.title, None if run is None else run.colour)
        in_past = self.content == "result" and not self.material.looks_at_a
        self.cell.strip.set_text(self.material.moment if in_past else "")
        layer = self._layer()
        if layer is None:
            self._depth = self._guessed = None
            self._stale = np.zeros((0, 0), bool)
            self._guesses.clear()
            self.show_nothing(self._reason())
        else:
            self._draw_layer(layer)
        self._stripes.setVisible(layer is not None and layer.guessed is not None)
        self._write_legend()

    def _layer(self) -> Layer | None:
        """What is distrusted is to be seen in depth in, under its stripes."""
        measured = self.material.measured
        if self.content == "depth-in":
            return None if measured is None else Layer(measured)
        column = self.material.swiped_at
        if self.content == "result" and column is not None:
            swiped = self.material.swiped(column)
            if swiped is not None:
                return swiped
        return self.material.layer(self.content)

    def _reason(self) -> str:
        if self.content == "truth":
            return "No truth: this frame has none"
        if self.content == "guide":
            return NO_GUIDE
        if self.content in RUNS:
            return f"No run {RUNS.index(self.content) + 1} is ticked for comparison"
        reasons = {"result": NO_RESULT, EARLIER: "No run before this one", INTERPOLATED: "Interpolating…"}
        return reasons.get(self.content, "")

    def _draw_layer(self, layer: Layer) -> None:
        depth, guessed = layer.depth, layer.guessed
        levels, table = self.material.ranges["depth"].levels or (0.0, 1.0), self.material.depth_table
        stale = np.zeros(depth.shape, bool) if layer.stale is None else layer.stale
        same = levels == self._levels and guessed is self._guessed is None and np.array_equal(table, self._table)
        if same and self._depth is not None and self._depth.shape == depth.shape:
            self._draw_changes(self._depth, depth, stale)
        else:
            self._levels, self._table, self._guessed = levels, table, guessed
            self._depth, self._stale = depth.copy(), stale.copy()
            self._draw_all(depth)

    def _draw_changes(self, drawn: Depth, depth: Depth, stale: Mask) -> None:
        box = union(changed_box(drawn, depth), changed_box(self._stale, stale))
        if box is not None:
            drawn[box], self._stale[box] = depth[box], stale[box]
            self.cell.view.image.update_indices(box, to_indices(depth[box], *self._levels), stale[box])

    def _draw_all(self, depth: Depth) -> None:
        self.cell.bar.set_table(self._table)
        self.cell.bar.set_levels(self._levels)
        indices = to_indices(depth, *self._levels)
        self._guesses.clear()
        if self._guessed is not None:
            self._guesses.set_indices(np.where(self._guessed, indices, 0).astype(np.uint8), self._table)
            indices = np.where(self._guessed, 0, indices).astype(np.uint8)
        self.cell.view.set_picture(indices, self._table, self._stale)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self._hatch = hatch
        self._swatch = hatch_brush(colours.muted, _STRIPE)
        self._stripes.set_brush(hatch_brush(QColor(0, 0, 0, 0), _STRIPE))

    def _write_legend(self) -> None:
        guessed = [(self._swatch, "guessed")] if self._stripes.isVisible() else []
        stale = [(QBrush(_STALE), "stale")] if self._stale.any() else []
        self.cell.set_legend([*guessed, *stale, (self._hatch, "missing")])

    def value_at(self, x: int, y: int) -> float | None:
        return number_at(self._depth, x, y)

    def values(self) -> NDArray[np.floating] | None:
        return None if self._depth is None else sample(self._depth)

    def leave(self) -> None:
        self.cell.view.remove(self._guesses)
        self.cell.view.remove(self._stripes)


_PARTS = {"depth-in": "distrust", "result": "result", "truth": "truth", "guide": "guide", INTERPOLATED: INTERPOLATED}
"""Part of the material that each depth is; others are runs."""
