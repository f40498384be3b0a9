"""Charts of a sweep: error over one parameter as a curve, or over two as a grid."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QToolTip, QWidget

from ...base import theme
from ...views.colours import error_table
from ...widgets.basics import Themed

_MIN_LABEL_DISTANCE = 52
"""Minimum distance between the labels of values [px]."""
_MIN_RANGE = 0.05
"""Minimum range of errors shown, as a share of the largest."""
_CLICK_DISTANCE = 40
"""Horizontal distance [px] within which a click hits a point."""


class ErrorCurve(Themed, pg.PlotWidget):
    """Plot with a point per tested value; the best points and the current value are marked.

    Signals
    -------
    taken(int)
        The point that was clicked, counted from the first value.
    """

    taken = Signal(int)

    def __init__(self) -> None:
        self._values = _ValueAxis()
        super().__init__(axisItems={"bottom": self._values}, enableMenu=False)
        self._places: list[float] = []
        self._logarithmic = False
        self._name = ""
        self.curve = pg.PlotDataItem(antialias=True, connect="finite", symbol="o", symbolSize=7)
        self.best = pg.ScatterPlotItem(size=15, symbol="o")
        self.present = pg.InfiniteLine(
            angle=90, label="current", labelOpts={"position": 0.95, "anchors": [(0, 0), (1, 0)], "movable": False}
        )
        self.addItem(self.present, ignoreBounds=True)
        self.addItem(self.curve)
        self.addItem(self.best)
        self.hideButtons()
        self.getViewBox().setMouseEnabled(x=False, y=False)
        self.getViewBox().setDefaultPadding(0.08)
        self.getAxis("left").enableAutoSIPrefix(False)
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        self.setAccessibleName("Error against the value")
        self.setToolTip("Error of every tested value. Click a point to apply its value.")
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self.set_points([], [], ())
        self._style()

    def set_scale(self, name: str, values: Sequence[float], logarithmic: bool) -> None:
        """Set the parameter's name, its values in rising order, and whether the axis is logarithmic."""
        self._name = name
        self._logarithmic = logarithmic and min(values) > 0
        self._places = [self._place(value) for value in values]
        self._values.set_ticks(self._places, [f"{value:g}" for value in values])
        self.getViewBox().setXRange(self._places[0], self._places[-1], padding=0.05)
        self._style()

    def set_present(self, value: float) -> None:
        """Mark the current value of the parameter, if it is in the range."""
        shown = not (self._logarithmic and value <= 0)
        place = self._place(value) if shown else math.nan
        shown = shown and bool(self._places) and self._places[0] <= place <= self._places[-1]
        self.present.setVisible(shown)
        if shown:
            self.present.setValue(place)

    def set_points(self, places: Sequence[int], errors: Sequence[float], best: Collection[int]) -> None:
        """Set the errors [m] of some of the values, NaN = none, and the best of them: several if these are equal."""
        known = dict(sorted(zip(places, errors, strict=True)))
        across = np.array([self._places[place] for place in known], float)
        above = 1000 * np.array(list(known.values()), float)
        self.curve.setData(across, above)
        if np.isfinite(above).any():
            # do not magnify negligible differences
            self.getViewBox().setLimits(minYRange=_MIN_RANGE * float(np.nanmax(above)))
        self.best.setData(pos=[(self._places[place], 1000 * known[place]) for place in sorted(best) if place in known])

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        if event.button() == Qt.MouseButton.LeftButton and self._places:
            at = event.position()
            distances = [abs(self._screen(place) - at.x()) for place in self._places]
            nearest = int(np.argmin(distances))
            if distances[nearest] <= _CLICK_DISTANCE:
                self.taken.emit(nearest)

    def _take_theme(self) -> None:
        if hasattr(self, "_name"):
            self._style()

    def point(self, number: int) -> QPointF:
        """Widget position of a value, at half height."""
        return QPointF(self._screen(self._places[number]), self.height() / 2)

    def _screen(self, place: float) -> float:
        return float(self.getViewBox().mapViewToScene(QPointF(place, 0)).x())

    def _place(self, value: float) -> float:
        return math.log10(value) if self._logarithmic else value

    def _style(self) -> None:
        colours = theme.colours(self.palette())
        self.setBackground(colours.background)
        accent, good = colours.accent, colours.good
        self.curve.setPen(pg.mkPen(accent, width=1.8))
        self.curve.setSymbolBrush(accent)
        self.curve.setSymbolPen(pg.mkPen(colours.background))
        self.best.setPen(pg.mkPen(good, width=2.5))
        self.best.setBrush(pg.mkBrush(None))
        self.present.setPen(pg.mkPen(colours.muted, style=Qt.PenStyle.DashLine))
        self.present.label.setColor(colours.muted)
        style_axis(self.getAxis("left"), "RMSE [mm]", colours)
        style_axis(self.getAxis("bottom"), self._name, colours)


class _ValueAxis(pg.AxisItem):
    """Axis with labels at the tested values, as many as fit."""

    def __init__(self) -> None:
        super().__init__("bottom")
        self.enableAutoSIPrefix(False)
        self._texts: dict[float, str] = {}

    def set_ticks(self, places: Sequence[float], texts: Sequence[str]) -> None:
        self._texts = dict(zip(places, texts, strict=True))
        self.picture = None
        self.update()

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        chosen: list[float] = []
        per_pixel = (maxVal - minVal) / max(size, 1)
        for place in sorted(self._texts):
            if not chosen or place - chosen[-1] >= _MIN_LABEL_DISTANCE * per_pixel:
                chosen.append(place)
        return [(1.0, chosen)]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        return [self._texts.get(value, "") for value in values]


def style_axis(axis: pg.AxisItem, label: str, colours: theme.Colours) -> None:
    """Set label and theme colours of an axis."""
    axis.setPen(colours.grid)
    axis.setTextPen(colours.muted)
    axis.setLabel(label, color=colours.muted.name())


# Errors of a sweep over two parameters: a cell for every pair of values.

_PAD = 8
_GAP = 1
_MIN_CELL = QSize(34, 18)
"""Minimum size of a cell with the error as text [px]."""
_RING = 2.5


class ErrorGrid(QWidget):
    """Grid of errors: columns are the first parameter's values, from the left; rows the second's, from below.

    Signals
    -------
    taken(int)
        The pair that was clicked, counted upwards in each column, column by column.
    """

    taken = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self._names = ("", "")
        self._values: tuple[Sequence[float], Sequence[float]] = ((), ())
        self._errors: Mapping[int, float] = {}
        self._best: Collection[int] = ()
        self._present: int | None = None
        self._table = error_table()
        self.setMouseTracking(True)
        self.setMinimumSize(220, 140)
        self.setAccessibleName("Error against both values")
        self.setCursor(Qt.CursorShape.PointingHandCursor)

    def set_scale(self, names: tuple[str, str], values: tuple[Sequence[float], Sequence[float]]) -> None:
        """Set the parameters' names, and their values in rising order."""
        self._names, self._values = names, values
        self._errors, self._best, self._present = {}, (), None
        self.update()

    def set_present(self, number: int | None) -> None:
        """Mark the pair of current values, if it is in the grid."""
        if number != self._present:
            self._present = number
            self.update()

    def set_errors(self, errors: Mapping[int, float], best: Collection[int]) -> None:
        """Set the errors [m] of the tested pairs, and the best of them: several if these are equal."""
        self._errors, self._best = errors, best
        self.update()

    def cell(self, number: int) -> QRectF:
        """Rectangle of a pair's cell."""
        columns, rows = (len(values) for values in self._values)
        area = self._area()
        width, height = area.width() / columns, area.height() / rows
        column, row = divmod(number, rows)
        corner = QPointF(area.left() + column * width, area.bottom() - (row + 1) * height)
        return QRectF(corner.x(), corner.y(), width - _GAP, height - _GAP)

    def paintEvent(self, event: QPaintEvent) -> None:
        if not all(self._values):
            return
        colours = theme.colours(self.palette())
        painter = QPainter(self)
        painter.fillRect(self.rect(), colours.background)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_labels(painter, colours)
        for number in range(len(self._values[0]) * len(self._values[1])):
            self._paint_cell(painter, number, colours)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for number in self._best:
            painter.setPen(QPen(colours.good, _RING))
            painter.drawRect(self.cell(number).adjusted(1, 1, -1, -1))
        if self._present is not None:
            inside = 1 + _RING * (self._present in self._best)
            painter.setPen(QPen(colours.text, _RING, Qt.PenStyle.DashLine))
            painter.drawRect(self.cell(self._present).adjusted(inside, inside, -inside, -inside))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        number = self._at(event.position())
        if number is not None and event.button() == Qt.MouseButton.LeftButton:
            self.taken.emit(number)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        number = self._at(event.position())
        if number is None:
            QToolTip.hideText()
            return
        column, row = divmod(number, len(self._values[1]))
        pair = f"{self._names[0]} {self._values[0][column]:g}, {self._names[1]} {self._values[1][row]:g}"
        error = self._errors.get(number, math.nan)
        known = f"{1000 * error:.4g} mm. Click to apply." if math.isfinite(error) else "no error yet."
        QToolTip.showText(event.globalPosition().toPoint(), f"{pair}: {known}", self)

    def _at(self, place: QPointF) -> int | None:
        count = len(self._values[0]) * len(self._values[1])
        return next((number for number in range(count) if self.cell(number).contains(place)), None)

    def _area(self) -> QRectF:
        metrics = self.fontMetrics()
        left = max((metrics.horizontalAdvance(f"{value:g}") for value in self._values[1]), default=0)
        line = metrics.height()
        return QRectF(self.rect()).adjusted(_PAD + line + left + 6, _PAD, -_PAD, -(2 * line + _PAD + 4))

    def _paint_labels(self, painter: QPainter, colours: theme.Colours) -> None:
        metrics, area = self.fontMetrics(), self._area()
        line, columns = metrics.height(), len(self._values[0])
        painter.setPen(colours.muted)
        widest = max(metrics.horizontalAdvance(f"{value:g}") for value in self._values[0]) + 6
        every = max(math.ceil(widest / (area.width() / columns)), 1)
        for column in range(0, columns, every):
            cell = self.cell(column * len(self._values[1]))
            where = QRectF(cell.center().x() - widest, area.bottom() + 2, 2 * widest, line)
            painter.drawText(where, Qt.AlignmentFlag.AlignCenter, f"{self._values[0][column]:g}")
        for row, value in enumerate(self._values[1]):
            cell = self.cell(row)
            where = QRectF(0, cell.center().y() - line / 2, area.left() - 4, line)
            painter.drawText(where, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, f"{value:g}")
        below = QRectF(area.left(), area.bottom() + 2 + line, area.width(), line)
        painter.drawText(below, Qt.AlignmentFlag.AlignCenter, f"{self._names[0]} · RMSE in mm")
        painter.save()
        painter.translate(_PAD, area.center().y())
        painter.rotate(-90)
        half = area.height() / 2
        painter.drawText(QRectF(-half, 0, 2 * half, line), Qt.AlignmentFlag.AlignCenter, self._names[1])
        painter.restore()

    def _paint_cell(self, painter: QPainter, number: int, colours: theme.Colours) -> None:
        cell, error = self.cell(number), self._errors.get(number, math.nan)
        painter.setPen(Qt.PenStyle.NoPen)
        if not math.isfinite(error):
            painter.setBrush(colours.panel)
            painter.drawRect(cell)
            return
        colour = self._colour(error)
        painter.setBrush(colour)
        painter.drawRect(cell)
        if cell.width() >= _MIN_CELL.width() and cell.height() >= _MIN_CELL.height():
            painter.setPen(QColor("black") if colour.lightness() > 120 else QColor("white"))
            painter.drawText(cell, Qt.AlignmentFlag.AlignCenter, f"{1000 * error:.3g}")

    def _colour(self, error: float) -> QColor:
        """Colour of an error, on a logarithmic scale from the smallest to the largest."""
        logs = np.log([max(one, 1e-6) for one in self._errors.values() if math.isfinite(one)])
        low, high = float(logs.min()), float(logs.max())
        share = (math.log(max(error, 1e-6)) - low) / (high - low) if high > low else 0.0
        red, green, blue, _ = (int(part) for part in self._table[1 + round(254 * share)])
        return QColor(red, green, blue)
