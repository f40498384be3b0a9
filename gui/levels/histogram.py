"""A histogram with the two levels between which colours lie, to be dragged."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QSignalBlocker, QTimer, Signal
from PySide6.QtGui import QColor, QFont

from gui import theme
from gui.views.ranges import Levels

_BINS = 120
_SHOWN = 0.5, 99.5
"""Percentiles of the values that the axis holds, and the levels in any case."""
_MARGIN = 0.04
_AXIS_HEIGHT = 20
_LEAST_LOG = 1e-3


class Histogram(pg.PlotWidget):
    """Counts of values on a linear or a logarithmic axis.

    Signals
    -------
    levelsDragged(float, float)
        The user has moved a level; once per turn of the event loop.
    """

    levelsDragged = Signal(float, float)

    def __init__(self) -> None:
        super().__init__(enableMenu=False)
        self._logarithmic = self._symmetric = False
        self._curve = pg.PlotCurveItem([0.0, 1.0], [0.0], stepMode="center", fillLevel=0)
        self._region = pg.LinearRegionItem(swapMode="block")
        self._region.setZValue(10)
        self.addItem(self._curve)
        self.addItem(self._region, ignoreBounds=True)
        self.hideButtons()
        self.hideAxis("left")
        self.getViewBox().setMouseEnabled(x=False, y=False)
        axis = self.getAxis("bottom")
        axis.enableAutoSIPrefix(False)
        axis.setHeight(_AXIS_HEIGHT)
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        self.setMinimumHeight(90)
        self.setAccessibleName("Histogram of what is shown")
        self.setToolTip("How often each value is shown. Drag the lines: they are the ends of the colours")
        self._told = QTimer(self, singleShot=True, interval=0)
        self._told.timeout.connect(lambda: self.levelsDragged.emit(*self.levels))
        self._region.sigRegionChanged.connect(self._drag)
        self._region.sigRegionChangeFinished.connect(self._drag)

    @property
    def levels(self) -> Levels:
        """Where the lines are."""
        low, high = self._region.getRegion()
        return (10.0**low, 10.0**high) if self._logarithmic else (float(low), float(high))

    def set_scale(self, logarithmic: bool, symmetric: bool) -> None:
        """Whether equal ratios are equally far apart, and whether the levels are centred at 0."""
        self._logarithmic, self._symmetric = logarithmic, symmetric
        axis = self.getAxis("bottom")
        axis.setLogMode(logarithmic)

    def show_values(self, values: NDArray[np.floating] | None, levels: Levels) -> None:
        """Draw the histogram of values, NaN for none, and put the lines at two levels; not while they are dragged."""
        if self._told.isActive() or any(line.moving for line in self._region.lines):
            return
        ends = self._on_axis(np.array(levels, float))
        known = np.zeros(0) if values is None else self._on_axis(values[np.isfinite(values)].astype(float))
        low, high = ends
        if known.size:
            least, most = np.percentile(known, _SHOWN)
            low, high = min(low, float(least)), max(high, float(most))
        margin = _MARGIN * (high - low)
        counts, edges = np.histogram(known, _BINS, (low - margin, high + margin))
        # the many pixels of one value, as 0, would hide all others
        self._curve.setData(edges, np.sqrt(counts))
        self.setXRange(low - margin, high + margin, padding=0)
        self.setYRange(0, float(np.sqrt(counts.max(initial=1))), padding=0.05)
        with QSignalBlocker(self._region):
            self._region.setRegion(tuple(ends))

    def set_movable(self, movable: bool) -> None:
        """Whether the lines can be dragged."""
        self._region.setMovable(movable)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Take the colours of the theme."""
        self.setBackground(colours.background)
        self._curve.setPen(pg.mkPen(colours.muted))
        tint = QColor(colours.muted)
        tint.setAlpha(90)
        self._curve.setBrush(tint)
        band = QColor(colours.accent)
        band.setAlpha(36)
        self._region.setBrush(band)
        for line in self._region.lines:
            line.setPen(pg.mkPen(colours.accent, width=2))
            line.setHoverPen(pg.mkPen(colours.accent, width=4))
        axis = self.getAxis("bottom")
        axis.setPen(colours.grid)
        axis.setTextPen(colours.muted)
        axis.setTickFont(font)

    def _on_axis(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.log10(np.maximum(values, _LEAST_LOG)) if self._logarithmic else values

    def _drag(self) -> None:
        if self._symmetric:
            low, high = self._region.getRegion()
            moved = next((line.value() for line in self._region.lines if line.moving), None)
            far = abs(moved) if moved is not None else (high - low) / 2
            with QSignalBlocker(self._region):
                self._region.setRegion((-far, far))
        low, high = self._region.getRegion()
        if low < high:
            self._told.start()
