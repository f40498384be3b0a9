"""The errors of a sweep over two parameters: a cell for every pair of values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QToolTip, QWidget

from gui import theme
from gui.views.colour_maps import error_table

_PAD = 8
_GAP = 1
_LEAST_CELL = QSize(34, 18)
"""Of which the error fits in as text [px]."""
_RING = 2.5


class ErrorGrid(QWidget):
    """Rows are the values of the second parameter, from below; columns those of the first, from the left.

    Signals
    -------
    taken(int)
        The pair that was clicked, counted up the columns, then from column to column.
    """

    taken = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self._names = ("", "")
        self._values: tuple[Sequence[float], Sequence[float]] = ((), ())
        self._errors: Mapping[int, float] = {}
        self._best: int | None = None
        self._present: int | None = None
        self._table = error_table()
        self.setMouseTracking(True)
        self.setMinimumSize(220, 140)
        self.setAccessibleName("Error against both values")
        self.setCursor(Qt.CursorShape.PointingHandCursor)

    def set_scale(self, names: tuple[str, str], values: tuple[Sequence[float], Sequence[float]]) -> None:
        """Which parameters, and their values in rising order."""
        self._names, self._values = names, values
        self._errors, self._best, self._present = {}, None, None
        self.update()

    def set_present(self, number: int | None) -> None:
        """Mark the pair of values as they are now, if it is among them."""
        if number != self._present:
            self._present = number
            self.update()

    def set_errors(self, errors: Mapping[int, float], best: int | None) -> None:
        """Errors [m] of the pairs that have been tried, and which of them is the best."""
        self._errors, self._best = errors, best
        self.update()

    def cell(self, number: int) -> QRectF:
        """Where a pair's cell is."""
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
        for marked, colour, style in (
            (self._present, colours.text, Qt.PenStyle.DashLine),
            (self._best, colours.good, Qt.PenStyle.SolidLine),
        ):
            if marked is not None:
                painter.setPen(QPen(colour, _RING, style))
                painter.setBrush(Qt.BrushStyle.NoBrush)
                painter.drawRect(self.cell(marked).adjusted(1, 1, -1, -1))

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
        known = f"{1000 * error:.4g} mm. Click to take them." if math.isfinite(error) else "no error yet."
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
        if cell.width() >= _LEAST_CELL.width() and cell.height() >= _LEAST_CELL.height():
            painter.setPen(QColor("black") if colour.lightness() > 120 else QColor("white"))
            painter.drawText(cell, Qt.AlignmentFlag.AlignCenter, f"{1000 * error:.3g}")

    def _colour(self, error: float) -> QColor:
        """Of the logarithm, between the least and the largest error."""
        logs = np.log([max(one, 1e-6) for one in self._errors.values() if math.isfinite(one)])
        low, high = float(logs.min()), float(logs.max())
        share = (math.log(max(error, 1e-6)) - low) / (high - low) if high > low else 0.0
        red, green, blue, _ = (int(part) for part in self._table[1 + round(254 * share)])
        return QColor(red, green, blue)
