"""The cells of depth, difference and expected error: what each draws of its numbers, in which colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from gui.theme import Colours
from gui.views.colour_maps import difference_table, error_table
from gui.views.items import hatch_brush
from gui.views.view_cell import EventHandler, ViewCell
from ilf.drawing.levels import robust_difference_level, robust_error_levels, to_indices

Depth = NDArray[np.float32]

_STRIPE = QColor(255, 255, 255, 190)


class DepthCell(ViewCell):
    """Depth in metres; what is missing shows the hatch, what is guessed is striped."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        # from below: the hatch of what is missing, guesses, stripes over them, and the rest of the depth
        self._guesses = self.view.add_layer(-0.8)
        self._stripes = self.view.add_hatch(-0.6)
        self._stripes.setVisible(False)
        self._missing, self._swatch = QBrush(), QBrush()

    def show_depth(
        self,
        depth: Depth | None,
        levels: tuple[float, float],
        table: NDArray[np.uint8],
        guessed: NDArray[np.bool_] | None = None,
    ) -> None:
        """Draw depth with the ends of the colours at some levels.

        Parameters
        ----------
        depth : ndarray of float32, shape (H, W), or None
            Depth [m], NaN missing; None for none.
        levels : (float, float)
            Depth [m] at the ends of the colours.
        table : ndarray of uint8, shape (256, 4)
        guessed : ndarray of bool, shape (H, W), optional
            Pixels whose depth is a guess. There is nothing missing then.
        """
        self.bar.set_table(table)
        self.bar.set_levels(None if depth is None else levels)
        self._stripes.setVisible(guessed is not None)
        self._guesses.clear()
        self._write_legend()
        if depth is None:
            self.view.set_picture(None)
            return
        indices = to_indices(depth, *levels)
        if guessed is not None:
            self._guesses.setImage(np.where(guessed, indices, 0).astype(np.uint8), autoLevels=False, lut=table)
            indices = np.where(guessed, 0, indices).astype(np.uint8)
        self.view.set_picture(indices, table)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        self._missing, self._swatch = hatch, hatch_brush(colours.muted, _STRIPE)
        self._stripes.set_brush(hatch_brush(QColor(0, 0, 0, 0), _STRIPE))
        self._write_legend()

    def _write_legend(self) -> None:
        guessed = [(self._swatch, "guessed")] if self._stripes.isVisible() else []
        self.strip.set_legend([*guessed, (self._missing, "missing")])


class DifferenceCell(ViewCell):
    """Depth out less depth in, where there are both; what was filled is marked."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        self._filled = self.view.add_layer(-0.5)
        self._before: Depth | None = None
        self._after: Depth | None = None
        self._marks = self._table = np.zeros((256, 4), np.uint8)

    def show_difference(self, before: Depth | None, after: Depth | None) -> None:
        """Draw the difference of two depths [m], float32 (H, W), NaN missing; None for none."""
        self._before, self._after = before, after
        self._draw()

    def _draw(self) -> None:
        if self._before is None or self._after is None:
            self._filled.clear()
            self.view.set_picture(None)
            self.bar.set_levels(None)
            return
        difference = (self._after - self._before) * np.float32(1000)
        level = robust_difference_level(difference)
        filled = np.isnan(self._before) & ~np.isnan(self._after)
        self._filled.setImage(filled.view(np.uint8), autoLevels=False, lut=self._marks)
        self.view.set_picture(to_indices(difference, -level, level), self._table)
        self.bar.set_levels((-level, level))

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        filled = mix(colours.background, colours.good, 0.55)
        self._marks = _mark_table(filled)
        self._table = difference_table(colours.is_dark)
        self.bar.set_table(self._table)
        self.strip.set_legend([(QBrush(filled), "filled"), (hatch, "missing")])
        self._draw()


class ErrorCell(ViewCell):
    """The expected error of what was filled, in logarithmic colours; what was measured is marked."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        self._measured = self.view.add_layer(-0.5)
        self._depth: Depth | None = None
        self._error: Depth | None = None
        self._marks = _mark_table(QColor())
        self._table = error_table()
        self.bar.set_table(self._table)

    def show_error(self, depth: Depth | None, error: Depth | None) -> None:
        """Draw expected errors [m], float32 (H, W), NaN where not filled, of a measured depth; None for none."""
        self._depth, self._error = depth, error
        self._draw()

    def _draw(self) -> None:
        if self._depth is None or self._error is None:
            self._measured.clear()
            self.view.set_picture(None)
            self.bar.set_levels(None)
            return
        millimetres = self._error * np.float32(1000)
        low, high = robust_error_levels(millimetres)
        measured = np.isfinite(self._depth)
        self._measured.setImage(measured.view(np.uint8), autoLevels=False, lut=self._marks)
        self.view.set_picture(to_indices(np.log(millimetres), np.log(low), np.log(high)), self._table)
        self.bar.set_levels((low, high), logarithmic=True)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        measured = mix(colours.background, colours.text, 0.2 if colours.is_dark else 0.14)
        self._marks = _mark_table(measured)
        self.strip.set_legend([(QBrush(measured), "measured"), (hatch, "missing")])
        self._draw()


def missing_brush(colours: Colours) -> QBrush:
    """The stripes that show through where depth is missing."""
    return hatch_brush(mix(colours.background, colours.text, 0.12), mix(colours.background, colours.text, 0.3))


def mix(first: QColor, second: QColor, share: float) -> QColor:
    """A colour between two others, at a share of the way to the second."""
    pairs = zip(_rgb(first), _rgb(second), strict=True)
    return QColor.fromRgbF(*(a + (b - a) * share for a, b in pairs))


def _rgb(colour: QColor) -> tuple[float, float, float]:
    return colour.redF(), colour.greenF(), colour.blueF()


def _mark_table(colour: QColor) -> NDArray[np.uint8]:
    """Table that shows 1 in a colour and 0 not at all."""
    table = np.zeros((256, 4), np.uint8)
    table[1] = colour.red(), colour.green(), colour.blue(), colour.alpha()
    return table
