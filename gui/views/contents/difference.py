"""The difference of two depths in millimetres, centred at 0; the error of the result against the truth is one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush

from gui.theme import Colours
from gui.views.changes import changed_box, union
from gui.views.colour_maps import difference_table
from gui.views.items import mix
from gui.views.view_cell import ViewCell
from ilf.blocks import Box
from ilf.drawing.levels import robust_difference_level, sample, to_indices

from .material import Depth, Material
from .names import INTERPOLATED, TITLES, compared_by, short_title
from .painter import NO_GUIDE, NO_RESULT, Painter, levels_of, mark_table, number_at

_MM = np.float32(1000)
_PARTS = {"depth-in": "distrust", "result": "result", "truth": "truth", "guide": "guide", INTERPOLATED: INTERPOLATED}


class DifferencePainter(Painter):
    """The first depth less the second, where there are both; where only one of them is, is marked."""

    range_kind = "signed"
    unit = "mm"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        self._pair = compared_by(content) or ("result", "depth-in")
        self.uses = frozenset({"levels", "runs", *(_PARTS.get(depth, "runs") for depth in self._pair)})
        super().__init__(content, cell, material)
        self._one_only = cell.view.add_layer(-0.5)
        self._drawn: tuple[_Operand, _Operand] | None = None
        self._level = 0.0
        self._marks = self._table = np.zeros((256, 4), np.uint8)
        self._one_only_brushes = [QBrush(), QBrush()]
        self._hatch = QBrush()

    @property
    def title(self) -> str:
        if self.content == "error":
            return TITLES["error"]
        names = self.material.names
        first, second = (short_title(depth, names) for depth in self._pair)
        return f"Difference: {first} \N{MINUS SIGN} {second}"

    def draw(self) -> None:
        material = self.material
        self.cell.strip.set_title(self.title)
        if material.looks_at_a and material.sides[0] in self._pair and self._drawn is not None:
            return  # while A stands in for the result, their difference stays to be seen
        layers = [material.layer(depth) for depth in self._pair]
        self._say("")
        if layers[0] is None or layers[1] is None:
            missing = self._pair[0] if layers[0] is None else self._pair[1]
            self._clear(self._reason(missing))
            return
        first, second = layers[0].depth, layers[1].depth
        few = (sample(first) - sample(second)) * _MM
        if not np.nanmax(np.abs(few), initial=0.0) > 0 and self._are_equal(first, second):
            return
        level = self._find_level(few, first, second)
        if self._drawn is not None and self._level == level and self._drawn[0].depth.shape == first.shape:
            self._draw_changes(self._drawn, first, second)
        else:
            self._draw_all(first, second, level)

    def _reason(self, depth: str) -> str:
        if depth == "result":
            return NO_RESULT
        if depth == "truth":
            return "No truth: this frame has none"
        if depth == "guide":
            return NO_GUIDE
        return "Interpolating\N{HORIZONTAL ELLIPSIS}" if depth == INTERPOLATED else "This run is not compared"

    def _are_equal(self, first: Depth, second: Depth) -> bool:
        """Say so where two depths are the same, and show nothing if there is nothing else to be seen."""
        both = np.isfinite(first) & np.isfinite(second)
        if (first[both] != second[both]).any():
            return False
        if np.array_equal(np.isfinite(first), np.isfinite(second)):
            self._clear("No difference")
            return True
        self._say("no difference" if both.any() else "nowhere are both known")
        return False

    def _say(self, text: str) -> None:
        """A word on the difference, and of when the result is."""
        moment = self.material.moment if "result" in self._pair else ""
        self.cell.strip.set_text(", ".join(part for part in (text, moment) if part))

    def _clear(self, message: str) -> None:
        self._drawn = None
        self._one_only.clear()
        self.cell.set_legend([])
        self.show_nothing(message)

    def _find_level(self, few: NDArray[np.float32], first: Depth, second: Depth) -> float:
        """What is equal, as measured depth mostly is, says nothing of how far the rest is apart."""

        def robust() -> tuple[float, float]:
            level = robust_difference_level(few[few != 0])
            return -level, level

        low, high = levels_of(self.material, "signed", robust, lambda: (first - second) * _MM)
        return max(abs(low), abs(high))

    def _draw_changes(self, drawn: tuple[_Operand, _Operand], first: Depth, second: Depth) -> None:
        box = union(drawn[0].take(first), drawn[1].take(second))
        if box is not None:
            indices, one_only = _difference(first[box], second[box], self._level)
            self._one_only.update_indices(box, one_only)
            self.cell.view.image.update_indices(box, indices)

    def _draw_all(self, first: Depth, second: Depth, level: float) -> None:
        self._drawn, self._level = (_Operand(first), _Operand(second)), level
        indices, one_only = _difference(first, second, level)
        self._one_only.set_indices(one_only, self._marks)
        self.cell.view.set_picture(indices, self._table)
        self.cell.bar.set_table(self._table)
        self.cell.bar.set_levels((-level, level))
        self._write_legend()

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        first = mix(colours.background, colours.good, 0.55)
        second = mix(colours.background, colours.warning, 0.55)
        self._marks = mark_table(first, second)
        self._table = difference_table(colours.is_dark)
        self._one_only_brushes = [QBrush(first), QBrush(second)]
        self._hatch = hatch
        self._drawn = None

    def _write_legend(self) -> None:
        names = self.material.names
        texts = [f"only {short_title(depth, names)}" for depth in self._pair]
        marks = list(zip(self._one_only_brushes, texts, strict=True))
        if self._pair[1] == "depth-in":
            marks = [(self._one_only_brushes[0], "filled")]
        self.cell.set_legend([*marks, (self._hatch, "missing")])

    def value_at(self, x: int, y: int) -> float | None:
        if self._drawn is None:
            return None
        first, second = (number_at(operand.depth, x, y, 1000.0) for operand in self._drawn)
        return None if first is None or second is None else first - second

    def values(self) -> NDArray[np.floating] | None:
        if self._drawn is None:
            return None
        first, second = (sample(operand.depth) for operand in self._drawn)
        return (first - second) * _MM

    def leave(self) -> None:
        self.cell.view.remove(self._one_only)


class _Operand:
    """A depth as it is drawn: a copy, since the result is changed in place."""

    def __init__(self, depth: Depth) -> None:
        self.depth = depth.copy()

    def take(self, depth: Depth) -> Box | None:
        """Take another state of it; where it differs."""
        box = changed_box(self.depth, depth)
        if box is not None:
            self.depth[box] = depth[box]
        return box


def _difference(first: Depth, second: Depth, level: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Indices of the difference of two depths [m], up to a level [mm]; and 1 where there is only the first, 2 where
    there is only the second."""
    known, other = np.isfinite(first), np.isfinite(second)
    one_only = (known & ~other).view(np.uint8) + 2 * (other & ~known).view(np.uint8)
    return to_indices((first - second) * _MM, -level, level), one_only
