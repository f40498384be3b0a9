"""The cells of depth, difference and expected error: what each draws of its numbers, in which colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor, QShowEvent

from gui.theme import Colours
from gui.views.changes import changed_box, union
from gui.views.colour_maps import difference_table, error_table
from gui.views.items import hatch_brush
from gui.views.view_cell import EventHandler, ViewCell
from ilf.drawing.levels import robust_difference_level, robust_error_levels, sample, to_indices

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]

_STRIPE = QColor(255, 255, 255, 190)
_STALE = QColor(140, 146, 140)


class DepthCell(ViewCell):
    """Depth in metres; what is missing shows the hatch, what is guessed is striped, what is stale is greyed."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        # from below: the hatch of what is missing, guesses, stripes over them, and the rest of the depth
        self._guesses = self.view.add_layer(-0.8)
        self._stripes = self.view.add_hatch(-0.6)
        self._stripes.setVisible(False)
        self._swatch = QBrush()
        # what is drawn: copies, since what is given may be changed in place
        self._depth: Depth | None = None
        self._stale: Mask = np.zeros((0, 0), bool)
        self._guessed: Mask | None = None
        self._levels = (0.0, 0.0)
        self._table = np.zeros((256, 4), np.uint8)

    def show_depth(
        self,
        depth: Depth | None,
        levels: tuple[float, float],
        table: NDArray[np.uint8],
        guessed: Mask | None = None,
        stale: Mask | None = None,
    ) -> None:
        """Draw depth with the ends of the colours at some levels, where it is not drawn so already.

        Parameters
        ----------
        depth : ndarray of float32, shape (H, W), or None
            Depth [m], NaN missing; None for none.
        levels : (float, float)
            Depth [m] at the ends of the colours.
        table : ndarray of uint8, shape (256, 4)
        guessed : ndarray of bool, shape (H, W), optional
            Pixels whose depth is a guess. There is nothing missing then.
        stale : ndarray of bool, shape (H, W), optional
            Pixels whose depth is of an older state of their block.
        """
        if depth is None:
            self._depth = self._guessed = None
            self._stale = np.zeros((0, 0), bool)
            self._guesses.clear()
            self.view.set_picture(None)
            self.bar.set_levels(None)
        else:
            stale = np.zeros(depth.shape, bool) if stale is None else stale
            same = levels == self._levels and guessed is self._guessed is None and np.array_equal(table, self._table)
            if same and self._depth is not None and self._depth.shape == depth.shape:
                self._draw_changes(self._depth, depth, stale)
            else:
                self._levels, self._table, self._guessed = levels, table, guessed
                self._depth, self._stale = depth.copy(), stale.copy()
                self._draw_all(depth)
        self._stripes.setVisible(guessed is not None)
        self._write_legend()

    def _draw_changes(self, drawn: Depth, depth: Depth, stale: Mask) -> None:
        box = union(changed_box(drawn, depth), changed_box(self._stale, stale))
        if box is not None:
            drawn[box], self._stale[box] = depth[box], stale[box]
            self.view.image.update_indices(box, to_indices(depth[box], *self._levels), stale[box])

    def _draw_all(self, depth: Depth) -> None:
        self.bar.set_table(self._table)
        self.bar.set_levels(self._levels)
        indices = to_indices(depth, *self._levels)
        self._guesses.clear()
        if self._guessed is not None:
            self._guesses.set_indices(np.where(self._guessed, indices, 0).astype(np.uint8), self._table)
            indices = np.where(self._guessed, 0, indices).astype(np.uint8)
        self.view.set_picture(indices, self._table, self._stale)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        self._swatch = hatch_brush(colours.muted, _STRIPE)
        self._stripes.set_brush(hatch_brush(QColor(0, 0, 0, 0), _STRIPE))
        self._write_legend()

    def _write_legend(self) -> None:
        guessed = [(self._swatch, "guessed")] if self._stripes.isVisible() else []
        stale = [(QBrush(_STALE), "stale")] if self._stale.any() else []
        self.set_legend([*guessed, *stale, (self.missing, "missing")])


class _LateCell(ViewCell):
    """A cell whose picture is drawn only for those who look at it."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        self._is_late = False

    def _draw(self) -> None:
        raise NotImplementedError

    def _draw_if_seen(self) -> None:
        self._is_late = not self.isVisible()
        if not self._is_late:
            self._draw()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self._is_late:
            self._draw_if_seen()


class DifferenceCell(_LateCell):
    """Depth out less depth in, where there are both; what was filled is marked."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        self._filled = self.view.add_layer(-0.5)
        self._before: Depth | None = None
        self._after: Depth | None = None
        self._drawn: tuple[Depth, Depth, float] | None = None
        self._marks = self._table = np.zeros((256, 4), np.uint8)

    def show_difference(self, before: Depth | None, after: Depth | None) -> None:
        """Draw the difference of two depths [m], float32 (H, W), NaN missing; None for none.

        What is drawn already is not drawn again; the second may be the same array, changed in place.
        """
        self._before, self._after = before, after
        self._draw_if_seen()

    def _draw(self) -> None:
        before, after, drawn = self._before, self._after, self._drawn
        if before is None or after is None:
            self._drawn = None
            self._filled.clear()
            self.view.set_picture(None)
            self.bar.set_levels(None)
            return
        level = robust_difference_level((sample(after) - sample(before)) * np.float32(1000))
        if drawn is not None and drawn[0] is before and drawn[2] == level:
            box = changed_box(drawn[1], after)
            if box is not None:
                drawn[1][box] = after[box]
                indices, filled = _difference(before[box], after[box], level)
                self._filled.update_indices(box, filled)
                self.view.image.update_indices(box, indices)
            return
        self._drawn = before, after.copy(), level
        indices, filled = _difference(before, after, level)
        self._filled.set_indices(filled, self._marks)
        self.view.set_picture(indices, self._table)
        self.bar.set_levels((-level, level))

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        filled = mix(colours.background, colours.good, 0.55)
        self._marks = _mark_table(filled)
        self._table = difference_table(colours.is_dark)
        self.bar.set_table(self._table)
        self.set_legend([(QBrush(filled), "filled"), (hatch, "missing")])
        self._drawn = None
        self._draw_if_seen()


class ErrorCell(_LateCell):
    """The expected error of what was filled, in logarithmic colours; what was measured is marked."""

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__(title, unit, on_event)
        self._measured = self.view.add_layer(-0.5)
        self._depth: Depth | None = None
        self._error: Depth | None = None
        self._drawn: tuple[Depth, Depth, tuple[float, float]] | None = None
        self._marks = _mark_table(QColor())
        self._table = error_table()
        self.bar.set_table(self._table)

    def show_error(self, depth: Depth | None, error: Depth | None) -> None:
        """Draw expected errors [m], float32 (H, W), NaN where not filled, of a measured depth; None for none.

        Neither is changed afterwards. What is drawn already is not drawn again.
        """
        self._depth, self._error = depth, error
        self._draw_if_seen()

    def _draw(self) -> None:
        depth, error, drawn = self._depth, self._error, self._drawn
        if depth is None or error is None:
            self._drawn = None
            self._measured.clear()
            self.view.set_picture(None)
            self.bar.set_levels(None)
            return
        levels = robust_error_levels(sample(error) * np.float32(1000))
        self._drawn = depth, error, levels
        if drawn is not None and drawn[0] is depth and drawn[2] == levels:
            box = changed_box(drawn[1], error)
            if box is not None:
                self.view.image.update_indices(box, _log_indices(error[box], levels))
            return
        self._measured.set_indices(np.isfinite(depth).view(np.uint8), self._marks)
        self.view.set_picture(_log_indices(error, levels), self._table)
        self.bar.set_levels(levels, logarithmic=True)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        super().set_colours(colours, hatch)
        measured = mix(colours.background, colours.text, 0.2 if colours.is_dark else 0.14)
        self._marks = _mark_table(measured)
        self.set_legend([(QBrush(measured), "measured"), (hatch, "missing")])
        self._drawn = None
        self._draw_if_seen()


def _difference(before: Depth, after: Depth, level: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Indices of the difference of two depths [m], up to a level [mm], and 1 where there was none before."""
    filled = np.isnan(before) & ~np.isnan(after)
    return to_indices((after - before) * np.float32(1000), -level, level), filled.view(np.uint8)


def _log_indices(error: Depth, levels: tuple[float, float]) -> NDArray[np.uint8]:
    """Indices of errors [m] on a logarithmic scale between two levels [mm]."""
    indices = np.zeros(error.shape, np.uint8)
    known = np.isfinite(error)
    low, high = np.log(levels)
    indices[known] = to_indices(np.log(error[known] * np.float32(1000)), low, high)
    return indices


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
