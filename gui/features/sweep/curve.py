"""Error over one parameter of a sweep, as a curve."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent

from ...base import theme
from ...widgets.basics import Themed

_MOST_LABELS = 10
"""Maximum number of values with a label."""
_MIN_RANGE = 0.05
"""Minimum range of errors shown, as a share of the largest."""
_LOW, _HIGH = 0.12, 0.95
"""Heights of the label of the current value, as shares of the plot's: the one that is farther from the curve."""
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
        super().__init__(enableMenu=False)
        self._places: list[float] = []
        self._logarithmic = False
        self._name = ""
        self.curve = pg.PlotDataItem(antialias=True, connect="finite", symbol="o", symbolSize=7)
        self.best = pg.ScatterPlotItem(size=15, symbol="o")
        self.present = pg.InfiniteLine(
            angle=90, label="current", labelOpts={"position": _HIGH, "anchors": [(0, 0), (1, 0)], "movable": False}
        )
        self.addItem(self.present, ignoreBounds=True)
        self.addItem(self.curve)
        self.addItem(self.best)
        self.hideButtons()
        self.getViewBox().setMouseEnabled(x=False, y=False)
        self.getViewBox().setDefaultPadding(0.08)
        for name in ("left", "bottom"):
            self.getAxis(name).enableAutoSIPrefix(False)
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        self.setAccessibleName("Error against the value")
        self.setToolTip("Error of every tested value. Click a point to apply its value.")
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self.set_points([], [], ())
        self._take_theme()

    def set_scale(self, name: str, values: Sequence[float], logarithmic: bool) -> None:
        """Set the parameter's name, its values in rising order, and whether the axis is logarithmic."""
        self._name = name
        self._logarithmic = logarithmic and min(values) > 0
        self._places = [self._place(value) for value in values]
        ticks = [(place, f"{value:g}") for place, value in zip(self._places, values, strict=True)]
        self.getAxis("bottom").setTicks([ticks[:: -(-len(ticks) // _MOST_LABELS)]])
        self.getViewBox().setXRange(self._places[0], self._places[-1], padding=0.05)
        self._take_theme()

    def set_present(self, value: float) -> None:
        """Mark the current value of the parameter, if it is in the range."""
        place = math.nan if self._logarithmic and value <= 0 else self._place(value)
        shown = bool(self._places) and self._places[0] <= place <= self._places[-1]
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
            lowest, highest = np.nanmin(above), np.nanmax(above)
            at = float(np.interp(self.present.value(), across, np.nan_to_num(above, nan=lowest)))
            self.present.label.setPosition(_LOW if at > (lowest + highest) / 2 else _HIGH)
        self.best.setData(pos=[(self._places[place], 1000 * known[place]) for place in sorted(best) if place in known])

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        if event.button() == Qt.MouseButton.LeftButton and self._places:
            on_screen = (self.getViewBox().mapViewToScene(QPointF(place, 0)).x() for place in self._places)
            distances = [abs(x - event.position().x()) for x in on_screen]
            nearest = int(np.argmin(distances))
            if distances[nearest] <= _CLICK_DISTANCE:
                self.taken.emit(nearest)

    def _place(self, value: float) -> float:
        return math.log10(value) if self._logarithmic else value

    def _take_theme(self) -> None:
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
        for axis, label in (("left", "RMSE [mm]"), ("bottom", self._name)):
            self.getAxis(axis).setPen(colours.grid)
            self.getAxis(axis).setTextPen(colours.muted)
            self.getAxis(axis).setLabel(label, color=colours.muted.name())
