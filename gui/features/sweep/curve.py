"""Error over one parameter of a sweep, as a curve."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent

from ...base import theme
from ...views.curves.axes import Plot, paint_plot, set_title
from ...widgets.basics import Themed

_MOST_LABELS = 10
"""Maximum number of values with a label."""
_MIN_RANGE = 0.05
"""Minimum range of errors shown, as a share of the largest: negligible differences are not magnified."""
_CLICK_DISTANCE = 40
"""Horizontal distance [px] within which a click hits a point."""


class ErrorCurve(Themed, Plot):
    """Plot with a point per tested value; the best points and the current value are marked.

    Signals
    -------
    taken(int)
        The point that was clicked, counted from the first value.
    """

    taken = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self._places: list[float] = []
        self._logarithmic = False
        self.curve = pg.PlotDataItem(antialias=True, connect="finite", symbol="o", symbolSize=7)
        self.best = pg.ScatterPlotItem(size=15, symbol="o", brush=None)
        label = {"position": 0.95, "anchors": [(0, 0), (1, 0)], "movable": False}
        self.present = pg.InfiniteLine(angle=90, label="current", labelOpts=label)
        self.addItem(self.present, ignoreBounds=True)
        self.addItem(self.curve)
        self.addItem(self.best)
        self.getViewBox().setMouseEnabled(x=False, y=False)
        self.getViewBox().setDefaultPadding(0.08)
        set_title(self.getAxis("left"), "RMSE [mm]")
        self.setAccessibleName("Error against the value")
        self.setToolTip("Error of every tested value. Click a point to apply its value.")
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self._take_theme()

    def set_scale(self, name: str, values: Sequence[float], logarithmic: bool) -> None:
        """Set the parameter's name, its values in rising order, and whether the axis is logarithmic."""
        self._logarithmic = logarithmic and min(values) > 0
        self._places = [self._place(value) for value in values]
        ticks = [(place, f"{value:g}") for place, value in zip(self._places, values, strict=True)]
        self.getAxis("bottom").setTicks([ticks[:: -(-len(ticks) // _MOST_LABELS)]])
        set_title(self.getAxis("bottom"), name)
        self.getViewBox().setXRange(self._places[0], self._places[-1], padding=0.05)

    def draw(self, errors: Sequence[float], best: Collection[int], present: float) -> None:
        """Draw the errors [m] of the first values, NaN = none; mark the best of them: several if these are equal; and
        the current value, if it is in the range."""
        above = 1000 * np.array(errors, float)
        if np.isfinite(above).any():
            self.getViewBox().setLimits(minYRange=_MIN_RANGE * float(np.nanmax(above)))
        self.curve.setData(np.array(self._places[: len(errors)]), above)
        self.best.setData(pos=[(self._places[number], above[number]) for number in sorted(best)])
        place = self._place(present)
        shown = self._places[0] <= place <= self._places[-1]
        self.present.setVisible(shown)
        if shown:
            self.present.setValue(place)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        super().mouseReleaseEvent(event)
        if event.button() == Qt.MouseButton.LeftButton and self._places:
            on_screen = (self.getViewBox().mapViewToScene(QPointF(place, 0)).x() for place in self._places)
            distances = [abs(x - event.position().x()) for x in on_screen]
            nearest = int(np.argmin(distances))
            if distances[nearest] <= _CLICK_DISTANCE:
                self.taken.emit(nearest)

    def _place(self, value: float) -> float:
        """The place of a value on the axis; NaN for one that a logarithmic axis does not have."""
        if not self._logarithmic:
            return value
        return math.log10(value) if value > 0 else math.nan

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        paint_plot(self, colours, self.font())
        self.curve.setPen(pg.mkPen(colours.accent, width=1.8))
        self.curve.setSymbolBrush(colours.accent)
        self.curve.setSymbolPen(pg.mkPen(colours.background))
        self.best.setPen(pg.mkPen(colours.good, width=2.5))
        self.present.setPen(pg.mkPen(colours.muted, style=Qt.PenStyle.DashLine))
        self.present.label.setColor(colours.muted)
        self.present.label.fill = pg.mkBrush(theme.faded(colours.background, 170))  # the curve may cross it
