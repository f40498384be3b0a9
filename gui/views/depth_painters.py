"""Painters of depth [m] (depth in, result, runs, ground truth), of differences and of the expected error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from ilf.data.label_map import Box
from ilf.drawing.colours import log_indices, robust_difference_level, robust_error_levels, sample, to_indices

from ..base.theme import Colours
from .colours import Levels, difference_table, error_table
from .contents import (
    BEFORE_IN,
    BEFORE_OUT,
    EARLIER,
    FLICKERS,
    INTERPOLATED,
    RUNS,
    TITLES,
    capital,
    operands_of,
    short_title,
)
from .painter import (
    EVERYWHERE,
    NO_GUIDE,
    Depth,
    Layer,
    Mask,
    Material,
    Painter,
    levels_of,
    mark_table,
    number_at,
)
from .pixel_items import changed_box, union
from .scene_items import blend, hatch_brush
from .view_cell import ViewCell

_STRIPE = QColor(255, 255, 255, 190)
_STALE = QColor(140, 146, 140)


class DepthPainter(Painter):
    """Painter of depth; missing depth is hatched, extrapolated depth striped, stale depth grey."""

    range_kind = "depth"
    unit = "m"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        # the invalid mask does not change depth in
        self._own_parts = frozenset({"frame" if content == "depth-in" else _PARTS.get(content, "runs"), "levels"})
        if content == "result":
            self._own_parts |= {"swipe", "runs"}
        self.uses = self._own_parts
        super().__init__(content, cell, material)
        # from below: the hatch of missing depth, extrapolated depth, stripes over it, and the rest of the depth
        self._extrapolations = cell.view.add_layer(-0.8)
        self._stripes = cell.view.add_hatch(-0.6)
        self._stripes.setVisible(False)
        self._swatch = QBrush()
        self._hatch = QBrush()
        # the drawn arrays: copies, since the originals may be changed in place
        self._depth: Depth | None = None
        self._stale: Mask = np.zeros((0, 0), bool)
        self._extrapolated: Mask | None = None
        self._levels: Levels = (0.0, 0.0)
        self._table = np.zeros((256, 4), np.uint8)

    @property
    def title(self) -> str:
        looked_at = self.content
        if looked_at == "result" and self.material.shows_a_as_result:
            looked_at = self.material.sides[0]
        if looked_at == "result" and self.material.swipe_column is not None:
            first, second = (short_title(side, self.material.names) for side in self.material.sides)
            return f"A: {first} | B: {second}"
        return TITLES.get(looked_at) or capital(short_title(looked_at, self.material.names))

    def draw(self) -> None:
        if self.content == "result":  # divided, or with side A in its place, it may be any depth
            others = self.material.swipe_column is not None or self.material.shows_a_as_result
            sides = {_PARTS.get(side, "runs") for side in self.material.sides} if others else set()
            self.uses = self._own_parts | sides
        run = self.material.run(self.content)
        self.cell.strip.set_title(self.title, None if run is None else run.colour)
        in_past = self.content == "result" and not self.material.shows_a_as_result
        self.cell.strip.set_text(self.material.moment if in_past else "")
        layer = self._layer()
        if layer is None:
            self._depth = self._extrapolated = None
            self._stale = np.zeros((0, 0), bool)
            self._extrapolations.clear()
            self.show_placeholder(self._reason())
        else:
            self._draw_layer(layer)
        self._stripes.setVisible(layer is not None and layer.extrapolated is not None)
        self._write_legend()

    def _layer(self) -> Layer | None:
        """The depth to draw; depth in includes invalid depth, under its stripes."""
        measured = self.material.measured
        if self.content == "depth-in":
            return None if measured is None else Layer(measured)
        column = self.material.swipe_column
        if self.content == "result" and column is not None:
            swiped = self.material.swiped(column)
            if swiped is not None:
                return swiped
        return self.material.layer(self.content)

    def _reason(self) -> str:
        if self.content == "ground_truth":
            return "This frame has no ground truth"
        if self.content == "guide":
            return NO_GUIDE
        if self.content in RUNS:
            return f"No run {RUNS.index(self.content) + 1} is ticked for comparison"
        reasons = {"result": self.material.no_result, EARLIER: "No run before this one", INTERPOLATED: "Interpolating…"}
        return reasons.get(self.content, "")

    def _draw_layer(self, layer: Layer) -> None:
        depth, extrapolated = layer.depth, layer.extrapolated
        levels, table = self.material.ranges["depth"].levels or (0.0, 1.0), self.material.depth_table
        stale = np.zeros(depth.shape, bool) if layer.stale is None else layer.stale
        same = (
            levels == self._levels and extrapolated is self._extrapolated is None and np.array_equal(table, self._table)
        )
        if same and self._depth is not None and self._depth.shape == depth.shape:
            self._draw_changes(self._depth, depth, stale)
        else:
            self._levels, self._table, self._extrapolated = levels, table, extrapolated
            self._depth, self._stale = depth.copy(), stale.copy()
            self._draw_all(depth)

    def _draw_changes(self, drawn: Depth, depth: Depth, stale: Mask) -> None:
        box = union(changed_box(drawn, depth), changed_box(self._stale, stale))
        if box is not None:
            drawn[box], self._stale[box] = depth[box], stale[box]
            image = self.cell.view.image
            image.update_indices(box, to_indices(depth[box], *self._levels), stale[box])
            if image.image is not None:
                self.cell.view.points.set_indices(image.image.astype(np.uint8, copy=False), self._table)

    def _draw_all(self, depth: Depth) -> None:
        self.cell.bar.set_table(self._table)
        self.cell.bar.set_levels(self._levels)
        indices = to_indices(depth, *self._levels)
        self._extrapolations.clear()
        if self._extrapolated is not None:
            self._extrapolations.set_indices(np.where(self._extrapolated, indices, 0).astype(np.uint8), self._table)
            indices = np.where(self._extrapolated, 0, indices).astype(np.uint8)
        self.cell.view.set_picture(indices, self._table, self._stale)
        self.cell.view.points.set_indices(indices, self._table)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self._hatch = hatch
        self._swatch = hatch_brush(colours.muted, _STRIPE)
        self._stripes.set_brush(hatch_brush(QColor(0, 0, 0, 0), _STRIPE))

    def _write_legend(self) -> None:
        extrapolated = [(self._swatch, "extrapolated")] if self._stripes.isVisible() else []
        stale = [(QBrush(_STALE), "stale")] if self._stale.any() else []
        self.cell.set_legend([*extrapolated, *stale, (self._hatch, "missing")])

    def value_at(self, x: int, y: int) -> float | None:
        return number_at(self._depth, x, y)

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        return None if self._depth is None else sample(self._depth[where])

    def leave(self) -> None:
        self.cell.view.remove(self._extrapolations)
        self.cell.view.remove(self._stripes)
        self.cell.view.points.set_extent(None)


_PARTS = {
    "depth-in": "invalid_mask",
    "result": "result",
    "ground_truth": "ground_truth",
    "guide": "guide",
    INTERPOLATED: INTERPOLATED,
    BEFORE_IN: "before",
    BEFORE_OUT: "before",
}
"""Part of the material of each depth; the others are runs."""


# The difference of two depths in millimetres, centred at 0, such as the error against ground truth.

_MM = np.float32(1000)
_FLICKER_PERCENT = 90
"""Share of the pixels in the colour range of flicker: beside outlines, a moving camera changes depth by far more."""


class DifferencePainter(Painter):
    """Painter of the first depth minus the second; pixels with only one of them are marked."""

    range_kind = "signed"
    unit = "mm"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        self._pair = operands_of(content) or ("result", "depth-in")
        self.uses = frozenset({"levels", "runs", *(_PARTS.get(depth, "runs") for depth in self._pair)})
        super().__init__(content, cell, material)
        self._single_depth = cell.view.add_layer(-0.5)
        self._drawn: tuple[_DrawnDepth, _DrawnDepth] | None = None
        self._level = 0.0
        self._marks = self._table = np.zeros((256, 4), np.uint8)
        self._one_only_brushes = [QBrush(), QBrush()]
        self._hatch = QBrush()

    @property
    def title(self) -> str:
        if self.content in TITLES:
            return TITLES[self.content]
        names = self.material.names
        first, second = (short_title(depth, names) for depth in self._pair)
        return f"Difference: {first} \N{MINUS SIGN} {second}"

    def draw(self) -> None:
        material = self.material
        self.cell.strip.set_title(self.title)
        if material.shows_a_as_result and material.sides[0] in self._pair and self._drawn is not None:
            return  # while A is shown in place of the result, their difference stays visible
        layers = [material.layer(depth) for depth in self._pair]
        self._show_note("")
        if layers[0] is None or layers[1] is None:
            missing = self._pair[0] if layers[0] is None else self._pair[1]
            self._clear(self._reason(missing))
            return
        first, second = layers[0].depth, layers[1].depth
        sampled = (sample(first) - sample(second)) * _MM
        if not np.nanmax(np.abs(sampled), initial=0.0) > 0 and self._are_equal(first, second):
            return
        level = self._find_level(sampled, first, second)
        if self._drawn is not None and self._level == level and self._drawn[0].depth.shape == first.shape:
            self._draw_changes(self._drawn, first, second)
        else:
            self._draw_all(first, second, level)

    def _reason(self, depth: str) -> str:
        if depth == "result":
            return self.material.no_result
        if depth == BEFORE_OUT and self.material.before.depth_in is not None:
            return "The frame before has no result"
        if depth in (BEFORE_IN, BEFORE_OUT):
            return self.material.before.text
        if depth == "ground_truth":
            return "This frame has no ground truth"
        if depth == "guide":
            return NO_GUIDE
        return "Interpolating\N{HORIZONTAL ELLIPSIS}" if depth == INTERPOLATED else "This run is not compared"

    def _are_equal(self, first: Depth, second: Depth) -> bool:
        """Show a note if two depths are equal, and no picture if they also have the same pixels; True if so."""
        both = np.isfinite(first) & np.isfinite(second)
        if (first[both] != second[both]).any():
            return False
        if np.array_equal(np.isfinite(first), np.isfinite(second)):
            self._clear("No difference")
            return True
        self._show_note("no difference" if both.any() else "no pixel has both")
        return False

    def _show_note(self, text: str) -> None:
        """Show a text about the difference, and the iteration of the result, or which frame is the one before."""
        if self.content in FLICKERS:
            about = "" if self.material.before.depth_in is None else self.material.before.text
        else:
            about = self.material.moment if "result" in self._pair else ""
        self.cell.strip.set_text(", ".join(part for part in (text, about) if part))

    def _clear(self, message: str) -> None:
        self._drawn = None
        self._single_depth.clear()
        self.cell.set_legend([])
        self.show_placeholder(message)

    def _find_level(self, sampled: NDArray[np.float32], first: Depth, second: Depth) -> float:
        """Range of the difference; equal pixels, such as most measured ones, are ignored."""

        def robust() -> tuple[float, float]:
            percent = _FLICKER_PERCENT if self.content in FLICKERS else 99
            level = robust_difference_level(sampled[sampled != 0], percent)
            return -level, level

        low, high = levels_of(self.material, "signed", robust, lambda: (first - second) * _MM)
        return max(abs(low), abs(high))

    def _draw_changes(self, drawn: tuple[_DrawnDepth, _DrawnDepth], first: Depth, second: Depth) -> None:
        box = union(drawn[0].take(first), drawn[1].take(second))
        if box is not None:
            indices, one_only = _difference(first[box], second[box], self._level)
            self._single_depth.update_indices(box, one_only)
            self.cell.view.image.update_indices(box, indices)

    def _draw_all(self, first: Depth, second: Depth, level: float) -> None:
        self._drawn, self._level = (_DrawnDepth(first), _DrawnDepth(second)), level
        indices, one_only = _difference(first, second, level)
        self._single_depth.set_indices(one_only, self._marks)
        self.cell.view.set_picture(indices, self._table)
        self.cell.bar.set_table(self._table)
        self.cell.bar.set_levels((-level, level))
        self._write_legend()

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        first = blend(colours.background, colours.good, 0.55)
        second = blend(colours.background, colours.warning, 0.55)
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
        elif self.content in FLICKERS:
            marks = [(self._one_only_brushes[0], "not seen before")]
        self.cell.set_legend([*marks, (self._hatch, "missing")])

    def value_at(self, x: int, y: int) -> float | None:
        if self._drawn is None:
            return None
        first, second = (number_at(operand.depth, x, y, 1000.0) for operand in self._drawn)
        return None if first is None or second is None else first - second

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        if self._drawn is None:
            return None
        first, second = (sample(operand.depth[where]) for operand in self._drawn)
        return (first - second) * _MM

    def leave(self) -> None:
        self.cell.view.remove(self._single_depth)


class _DrawnDepth:
    """Copy of a depth as drawn, since the result is changed in place."""

    def __init__(self, depth: Depth) -> None:
        self.depth = depth.copy()

    def take(self, depth: Depth) -> Box | None:
        """Update the copy and return the box of the changes."""
        box = changed_box(self.depth, depth)
        if box is not None:
            self.depth[box] = depth[box]
        return box


def _difference(first: Depth, second: Depth, level: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Indices of the difference of two depths [m], up to a level [mm]; and a map with 1 where only the first is known,
    2 where only the second is."""
    known, other = np.isfinite(first), np.isfinite(second)
    one_only = (known & ~other).view(np.uint8) + 2 * (other & ~known).view(np.uint8)
    return to_indices((first - second) * _MM, -level, level), one_only


# The expected error of filled pixels, in logarithmic colours; measured pixels are marked.
#
# Unsupported pixels have stripes over the picture.

_MIN_MM = 0.01
_ESTIMATING = "Estimating\N{HORIZONTAL ELLIPSIS}"


class ExpectedErrorPainter(Painter):
    """Painter of the expected error, grey where depth is stale. Neither depth in nor the error is changed in place."""

    uses = frozenset({"invalid_mask", "expected-error", "levels", "moment", "result"})
    range_kind = "expected"
    unit = "mm"

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        super().__init__(content, cell, material)
        self._measured = cell.view.add_layer(-0.5)
        cell.view.shows_unsupported = True
        self._drawn: tuple[Depth, Depth, Levels] | None = None
        self._stale: Mask = np.zeros((0, 0), bool)
        self._legend: list[tuple[QBrush, str]] = []
        self._marks = mark_table(QColor())
        self._table = error_table()
        cell.bar.set_table(self._table)

    def draw(self) -> None:
        depth, error, drawn = self.material.depth_in, self.material.expected, self._drawn
        outdated = error is not None and self.material.error_is_outdated
        note = "of the current result" if error is not None and self.material.moment else ""
        self.cell.strip.set_text("of the previous result" if outdated else note)
        if depth is None or error is None:
            self._drawn = None
            self._measured.clear()
            self.show_placeholder(_ESTIMATING if self.material.error_is_outdated else self.material.no_result)
            return
        sampled = sample(error) * _MM
        low, high = levels_of(self.material, "expected", lambda: robust_error_levels(sampled), lambda: error * _MM)
        levels = max(low, _MIN_MM), max(high, 2 * max(low, _MIN_MM))
        former, self._stale = self._stale, self._stale_pixels(depth.shape)
        self._drawn = depth, error, levels
        self._write_legend()
        if drawn is not None and drawn[0] is depth and drawn[2] == levels:
            box = union(None if drawn[1] is error else changed_box(drawn[1], error), changed_box(former, self._stale))
            if box is not None:
                self.cell.view.image.update_indices(box, log_indices(error[box], levels), self._stale[box])
            return
        self._measured.set_indices(np.isfinite(depth).view(np.uint8), self._marks)
        self.cell.view.set_picture(log_indices(error, levels), self._table, self._stale)
        self.cell.bar.set_levels(levels, logarithmic=True)

    def _stale_pixels(self, shape: tuple[int, ...]) -> Mask:
        result = self.material.result
        return np.zeros(shape, bool) if result is None or result.stale is None else result.stale.copy()

    def _write_legend(self) -> None:
        stale = [(QBrush(_STALE), "stale")] if self._stale.any() else []
        self.cell.set_legend([*stale, *self._legend])

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        measured = blend(colours.background, colours.text, 0.2 if colours.is_dark else 0.14)
        self._marks = mark_table(measured)
        self._legend = [(QBrush(measured), "measured"), (hatch, "missing")]
        self._write_legend()
        self._drawn = None

    def value_at(self, x: int, y: int) -> float | None:
        return None if self._drawn is None else number_at(self._drawn[1], x, y, 1000.0)

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        return None if self._drawn is None else sample(self._drawn[1][where]) * _MM

    def leave(self) -> None:
        self.cell.view.remove(self._measured)
        self.cell.view.shows_unsupported = False
