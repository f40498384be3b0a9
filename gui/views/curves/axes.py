"""Plain plots, and their axes: lengths on a logarithmic scale, and sums; their titles and colours."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pyqtgraph as pg
from PySide6.QtCore import QEvent, Signal
from PySide6.QtGui import QFont

from ilf._runtime.formatting import length_text

from ...base import theme

_AXIS_WIDTH = 64
_MIN_TICK_DISTANCE = 17  # minimum distance between the labels of a vertical axis [px]


def set_title(axis: pg.AxisItem, text: str, **style: str) -> None:
    """Set the title of an axis, in the middle of it: pyqtgraph places it anew only when the size changes."""
    axis.setLabel(text, **style)
    axis.resizeEvent()


class Plot(pg.PlotWidget):
    """A plot without menu, buttons and frame, whose axes have no prefixes of units."""

    def __init__(self, **axes: pg.AxisItem) -> None:
        super().__init__(enableMenu=False, axisItems=axes)
        self.hideButtons()
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        for name in ("left", "bottom"):
            self.getAxis(name).enableAutoSIPrefix(False)


class PointedPlot(Plot):
    """A plot with a cursor across it, which tells where the mouse is.

    Signals
    -------
    hovered(float)
        Position on the horizontal axis under the mouse, NaN when it leaves.
    """

    hovered = Signal(float)

    def __init__(self, **axes: pg.AxisItem) -> None:
        super().__init__(**axes)
        self.cursor_line = pg.InfiniteLine(angle=90)
        self.cursor_line.hide()
        self.addItem(self.cursor_line, ignoreBounds=True)
        self.scene().sigMouseMoved.connect(
            lambda position: self.hovered.emit(self.getViewBox().mapSceneToView(position).x())
        )

    def point_at(self, place: float | None) -> None:
        """Put the cursor at a position of the horizontal axis; None hides it."""
        self.cursor_line.setVisible(place is not None)
        if place is not None:
            self.cursor_line.setValue(place)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(math.nan)


def paint_plot(plot: pg.PlotWidget, colours: theme.Colours, font: QFont) -> None:
    """Give a plot's ground and axes the theme's colours, and the axes a font."""
    plot.setBackground(colours.background)
    for name in ("left", "bottom"):
        axis = plot.getAxis(name)
        axis.setPen(colours.grid)
        axis.setTextPen(colours.muted)
        axis.setTickFont(font)


class _Axis(pg.AxisItem):
    """Vertical axis of the width that all have."""

    def __init__(self) -> None:
        super().__init__("left")
        self.setWidth(_AXIS_WIDTH)


class LengthAxis(_Axis):
    """Vertical axis whose values are log10 of metres and whose labels are lengths."""

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        """Whole decades, thinned to fit the labels; 1, 2, 5 where few decades are in view."""
        first, last = math.ceil(minVal - 1e-9), math.floor(maxVal + 1e-9)
        labels = max(size / _MIN_TICK_DISTANCE, 1.0)
        decades = maxVal - minVal
        step = max(1, math.ceil(decades / labels))
        major = [float(power) for power in range(first, last + 1) if power % step == 0]
        minor: list[float] = []
        if decades * 3 <= labels and decades < 3:
            steps = (math.log10(2), math.log10(5))
            minor = [p + s for p in range(first - 1, last + 1) for s in steps if minVal <= p + s <= maxVal]
        return [(float(step), major), (0.3, minor)]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        return [length_text(10.0**value) for value in values]


class SumAxis(_Axis):
    """Vertical axis for sums of metres: plain numbers with thousands separated."""

    def __init__(self) -> None:
        super().__init__()
        self.setStyle(maxTickLevel=0)

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        """Round values, thinned to fit the labels."""
        labels = max(size / _MIN_TICK_DISTANCE, 1.0)
        spacing, values = super().tickValues(minVal, maxVal, size)[0]
        return [(spacing, values[:: math.ceil(len(values) / labels)])]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        digits = max(0, -math.floor(math.log10(spacing) + 1e-9))
        return [f"{value:.2e}" if abs(value) >= 1e7 else f"{value:,.{digits}f}" for value in values]
