"""The error against the value of a parameter: a curve with its best point and the present value marked."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent

from gui import theme

_LABEL_WIDTH = 52
"""Least distance between the labels of values [px]."""
_LEAST_RANGE = 0.05
"""Range of the errors that is shown at least, as a share of the largest."""
_REACH = 40
"""How far from a point a click still means it, across [px]."""


class ErrorCurve(pg.PlotWidget):
    """A point per value that has been tried.

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
            angle=90, label="now", labelOpts={"position": 0.95, "anchors": [(0, 0), (1, 0)], "movable": False}
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
        self.setToolTip("The error at every value that was tried. Click a point to take its value.")
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self.set_points([], [], None)
        self._style()

    def set_scale(self, name: str, values: Sequence[float], logarithmic: bool) -> None:
        """Which parameter, its values in rising order, and whether their ratios count."""
        self._name = name
        self._logarithmic = logarithmic and min(values) > 0
        self._places = [self._place(value) for value in values]
        self._values.set_ticks(self._places, [f"{value:g}" for value in values])
        self.getViewBox().setXRange(self._places[0], self._places[-1], padding=0.05)
        self._style()

    def set_present(self, value: float) -> None:
        """Mark the value that the parameter has now, where it is in the range."""
        shown = not (self._logarithmic and value <= 0)
        place = self._place(value) if shown else math.nan
        shown = shown and bool(self._places) and self._places[0] <= place <= self._places[-1]
        self.present.setVisible(shown)
        if shown:
            self.present.setValue(place)

    def set_points(self, places: Sequence[int], errors: Sequence[float], best: int | None) -> None:
        """Errors [m] of some of the values, NaN where there is none, and which of them is the best."""
        known = dict(sorted(zip(places, errors, strict=True)))
        across = np.array([self._places[place] for place in known], float)
        above = 1000 * np.array(list(known.values()), float)
        self.curve.setData(across, above)
        if np.isfinite(above).any():
            # what makes next to no difference is not to look like one
            self.getViewBox().setLimits(minYRange=_LEAST_RANGE * float(np.nanmax(above)))
        self.best.setData(pos=[(self._places[best], 1000 * known[best])] if best in known else [])

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        if event.button() == Qt.MouseButton.LeftButton and self._places:
            at = event.position()
            distances = [abs(self._screen(place) - at.x()) for place in self._places]
            nearest = int(np.argmin(distances))
            if distances[nearest] <= _REACH:
                self.taken.emit(nearest)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_name"):
            self._style()

    def point(self, number: int) -> QPointF:
        """Where on the widget a value is, at half height."""
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
    """Labels at the values that are tried, as many as have room."""

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
            if not chosen or place - chosen[-1] >= _LABEL_WIDTH * per_pixel:
                chosen.append(place)
        return [(1.0, chosen)]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        return [self._texts.get(value, "") for value in values]


def style_axis(axis: pg.AxisItem, label: str, colours: theme.Colours) -> None:
    """An axis in the theme's colours."""
    axis.setPen(colours.grid)
    axis.setTextPen(colours.muted)
    axis.setLabel(label, color=colours.muted.name())
