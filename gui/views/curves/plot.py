"""Plots over iterations or time: a line for each curve, stage marks, the colour-weighted span and a cursor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFont

from ...base import theme
from .axes import set_title
from .curve import Values

NAMED_AXIS, AXIS, _BARE = 34, 20, 6
"""Heights of the horizontal axis [px]: with name, with numbers only, and bare."""

_ERROR_RANGE = 0.4
"""Range [decades] above the minimum hold-out error that its plot shows."""

_MARK_ROW = 0.05
"""Height of the stage marks of one of several curves, as a share of the plot."""

_POINT = 6
"""Size of a curve that is a single point [px]."""


class Line(NamedTuple):
    """A curve in a plot: positions along the axis, values there (NaN: none), and style."""

    along: Values
    values: Values
    colour: QColor
    dashed: bool


class ConvergencePlot(pg.PlotWidget):
    """Lines over iterations or time with stage marks, the colour-weighted span and a cursor.

    The ranges grow in steps: while they stay the same, new values are drawn quickly.

    Parameters
    ----------
    axis : pyqtgraph.AxisItem
        The vertical axis.
    label : str
        Quantity on the vertical axis.
    min_span : float
        Minimum span of values in view.

    Signals
    -------
    hovered(float)
        Position on the horizontal axis under the mouse, NaN when it leaves.
    moved(float, float)
        The user zoomed or panned the horizontal axis: its visible range.
    fit_requested()
        The user double-clicked to follow all iterations again.
    """

    hovered = Signal(float)
    moved = Signal(float, float)
    fit_requested = Signal()

    def __init__(self, axis: pg.AxisItem, label: str, min_span: float = 0.0) -> None:
        super().__init__(viewBox=pg.ViewBox(enableMenu=False), axisItems={"left": axis}, enableMenu=False)
        self._label = label
        self.setAccessibleName(f"Plot: {label or 'errors'}")
        self._least_span = min_span
        self._span_name: pg.InfLineLabel | None = None
        self.lines: list[_Curve] = []
        self._points = pg.ScatterPlotItem(size=_POINT, pen=pg.mkPen(None))
        self._stages: list[pg.VTickGroup] = []
        self._stage_pen = pg.mkPen()
        self._marked: tuple[list[list[float]], list[int]] | None = None
        self._span = pg.LinearRegionItem(movable=False, pen=pg.mkPen(None))
        self._span.setZValue(-20)
        self._cursor = pg.InfiniteLine(angle=90)
        for item in (self._span, self._cursor):
            item.setVisible(False)
            self.addItem(item, ignoreBounds=True)
        self.addItem(self._points)
        self.plotItem.setContentsMargins(4, 7, 4, 2)
        self.hideButtons()
        view = self.getViewBox()
        view.setMouseEnabled(x=True, y=False)
        view.disableAutoRange()
        view.sigRangeChangedManually.connect(lambda *_: self.moved.emit(*view.viewRange()[0]))
        self.follows = True
        """Whether all iterations are in view."""
        self.marked: list[float] = []
        """Values that are always in view."""
        self._ranges: dict[int, tuple[float, float]] = {}
        self.getAxis("bottom").enableAutoSIPrefix(False)
        self.getAxis("bottom").setStyle(maxTickLevel=0)
        self.show_axis_labels(True)
        self.set_by_time(False)
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        self.setStatusTip("Wheel or drag: zoom and pan along the iterations. Double-click: show all.")
        self.scene().sigMouseMoved.connect(self._mouse_moved)

    def set_by_time(self, on: bool) -> None:
        """Set the horizontal axis to seconds, or to iterations."""
        self._places = "Time [s]" if on else "Iteration i"
        self._min_end = 0.01 if on else 10.0
        self.getViewBox().setLimits(xMin=0, minXRange=0.1 * self._min_end)
        set_title(self.getAxis("bottom"), self._places)

    def set_label(self, text: str) -> None:
        """Set the label of the vertical axis."""
        if text != self._label:
            self._label = text
            set_title(self.getAxis("left"), text)

    def show_lines(self, lines: Sequence[Line]) -> None:
        """Draw these lines and bring them into view; a line with a single value is drawn as a point."""
        while len(self.lines) < len(lines):
            self.lines.append(_Curve())
            self.addItem(self.lines[-1])
        alone = sum(line.values.size > 1 for line in lines) == 1
        for item, line in zip(self.lines, lines, strict=False):
            item.show_line(line, alone)
        for item in self.lines[len(lines) :]:
            item.setVisible(False)
        points = [line for line in lines if np.count_nonzero(np.isfinite(line.values)) == 1]
        self._points.setVisible(bool(points))
        if points:
            at = [int(np.flatnonzero(np.isfinite(line.values))[0]) for line in points]
            self._points.setData(
                [line.along[one] for line, one in zip(points, at, strict=True)],
                [line.values[one] for line, one in zip(points, at, strict=True)],
                brush=[line.colour for line in points],
            )

        if lines:
            self._follow(lines)

    def _follow(self, lines: Sequence[Line]) -> None:
        """Bring lines into view: all iterations if they are followed, and all values."""
        if self.follows:
            begin = min(float(line.along[0]) for line in lines)
            end = max(self._min_end, *(float(line.along[-1]) for line in lines))
            self._show_range(0, *_widened(0.0 if begin <= end / 4 else begin, end))
        finite = [line.values[np.isfinite(line.values)] for line in lines]
        extremes = [value for values in finite if values.size for value in (values.min(), values.max())]
        if extremes:
            self.show_values(float(min(*extremes, *self.marked)), float(max(*extremes, *self.marked)))

    def show_values(self, low: float, high: float) -> None:
        """Bring values into view, with room for a line of text above and below, and below what is marked."""
        missing = max(self._least_span - (high - low), 0.0) / 2
        room = 0.12 * (high - low) + missing or 0.5
        top = high + room
        bottoms = [low - room, *(mark - self._text_share * (top - mark) for mark in self.marked)]
        self._show_range(1, *_widened(min(bottoms), top))

    @property
    def _text_share(self) -> float:
        """Height of a line of text, as a share of that of the values above it; at most as much again."""
        line, height = 1.5 * self.fontMetrics().height(), self.getViewBox().height()
        return min(line / max(height - line, line), 1.0)

    def _show_range(self, axis: int, low: float, high: float) -> None:
        if self._ranges.get(axis) != (low, high):
            self._ranges[axis] = low, high
            (self.setYRange if axis else self.setXRange)(low, high, padding=0)

    def show_stages(self, stages: Sequence[Sequence[float]], colours: Sequence[QColor]) -> None:
        """Mark the starts of stages: for one curve over the full height, for several in one row each at the bottom."""
        looks = [list(places) for places in stages], [colour.rgb() for colour in colours]
        if looks == self._marked:
            return
        self._marked = looks
        for group in self._stages:
            self.removeItem(group)
        self._stages.clear()
        for row, places in enumerate(stages):
            height = [0, 1] if len(stages) == 1 else [row * _MARK_ROW, (row + 0.8) * _MARK_ROW]
            pen = self._stage_pen if len(stages) == 1 else pg.mkPen(colours[row])
            group = pg.VTickGroup(list(places), height, pen)
            group.setZValue(-10)
            self._stages.append(group)
            self.addItem(group, ignoreBounds=True)

    def show_span(self, span: tuple[float, float] | None) -> None:
        """Shade the colour-weighted iterations."""
        self._span.setVisible(span is not None)
        if span is not None:
            self._span.setRegion(span)

    def label_span(self, text: str) -> None:
        """Label the shaded span in the plot."""
        self._span_name = pg.InfLineLabel(self._span.lines[0], text, position=0.01, anchors=[(0, 1), (0, 1)])

    def point_at(self, place: float | None) -> None:
        """Put the cursor at a position of the horizontal axis; None hides it."""
        self._cursor.setVisible(place is not None)
        if place is not None:
            self._cursor.setValue(place)

    def reset_ranges(self) -> None:
        """Reset the ranges: the next lines are brought into view."""
        self.follows = True
        self._ranges.clear()

    def show_axis_labels(self, shown: bool, named: bool = True) -> None:
        """Show numbers and name of the horizontal axis, or only its line."""
        axis = self.getAxis("bottom")
        axis.setStyle(showValues=shown)
        axis.showLabel(shown and named)
        axis.setHeight((NAMED_AXIS if named else AXIS) if shown else _BARE)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Apply the theme's colours."""
        self.setBackground(colours.background)
        self._stage_pen = pg.mkPen(colours.grid)
        self._marked = None
        tint = QColor(colours.accent)
        tint.setAlpha(28)
        self._span.setBrush(tint)
        self._cursor.setPen(pg.mkPen(colours.muted))
        if self._span_name is not None:
            self._span_name.setColor(colours.muted)
            self._span_name.setFont(font)
            self._span_name.fill = text_background(colours)
        for name, text in (("left", self._label), ("bottom", self._places)):
            axis = self.getAxis(name)
            axis.setPen(colours.grid)
            axis.setTextPen(colours.muted)
            axis.setTickFont(font)
            set_title(axis, text, color=colours.muted.name(), **{"font-size": f"{font.pointSizeF():.1f}pt"})

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit_requested.emit()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(math.nan)

    def _mouse_moved(self, position: QPointF) -> None:
        self.hovered.emit(self.getViewBox().mapSceneToView(position).x())


class HoldOutPlot(ConvergencePlot):
    """Plot of hold-out errors; for one curve also of their minimum and of the errors at the other known pixels.

    The range is near the minimum hold-out error: the first errors may be 100 times as large, and the rise after the
    minimum, which shows where noise begins, would be invisible beside them.
    """

    def __init__(self, axis: pg.AxisItem) -> None:
        super().__init__(axis, "Hold-out")
        self.residual = pg.PlotCurveItem(antialias=True, connect="finite")
        self._minimum_line = pg.InfiniteLine(
            angle=90, label="", labelOpts={"position": 0.97, "anchors": [(0, 0), (1, 0)], "movable": False}
        )
        for item in (self.residual, self._minimum_line):
            self.addItem(item, ignoreBounds=True)
            item.setVisible(False)

    @property
    def minimum(self) -> str:
        """Label of the minimum hold-out error; "" if it is hidden."""
        return self._minimum_line.label.toPlainText() if self._minimum_line.isVisible() else ""

    def show_errors(self, lines: Sequence[Line], residual: Line | None, iterations: Values) -> None:
        """Draw hold-out errors, log10 of metres; for a single curve with the residual and the minimum marked.

        Parameters
        ----------
        lines : sequence of Line
            Hold-out errors, not all of them NaN.
        residual : Line or None
        iterations : ndarray
            Iterations of the first line.
        """
        self.show_lines(lines)
        alone = residual is not None
        self.residual.setVisible(alone)
        self._minimum_line.setVisible(alone)
        bottom = minimum = min(float(np.nanmin(line.values)) for line in lines if np.isfinite(line.values).any())
        if residual is not None:
            self.residual.setData(residual.along, residual.values)
            self.residual.setPen(pg.mkPen(residual.colour, width=1.4))
            place = int(np.nanargmin(lines[0].values))
            self._minimum_line.setValue(lines[0].along[place])
            self._minimum_line.label.setFormat(f"minimum at i = {int(iterations[place])}")
            bottom = min(minimum, float(np.nanmin(residual.values)))
        self.show_values(bottom, minimum + _ERROR_RANGE)

    def _follow(self, lines: Sequence[Line]) -> None:
        """Leave the ranges unchanged: `show_errors` brings values near the minimum into view."""

    def set_error_colours(self, colours: theme.Colours, held_out: QColor, residual: QColor, font: QFont) -> None:
        """Apply the theme's colours. The axis label names the curves in their colours."""
        names = ((held_out, "Hold-out"), (residual, "residual"))
        self._label = ", ".join(f'<span style="color: {colour.name()}">{name}</span>' for colour, name in names)
        self.set_colours(colours, font)
        self._minimum_line.setPen(pg.mkPen(held_out, width=1))
        self._minimum_line.label.setColor(held_out)
        self._minimum_line.label.setFont(font)
        self._minimum_line.label.fill = text_background(colours)


def _widened(low: float, high: float) -> tuple[float, float]:
    """Widen a range to round ends, so that it does not change with every new value."""
    step = 2.0 ** (math.floor(math.log2(max(high - low, 1e-9))) - 3)
    return math.floor(low / step) * step, math.ceil(high / step) * step


class _Curve(pg.PlotCurveItem):
    """A line with its own style; several lines are thin, since thin lines draw quickly."""

    def __init__(self) -> None:
        super().__init__(antialias=True, connect="finite")
        self._looks: tuple[QColor, bool, bool] | None = None

    def show_line(self, line: Line, alone: bool) -> None:
        """Draw a line; `alone` if it is the only one."""
        looks = line.colour, line.dashed, alone
        if looks != self._looks:
            self._looks = looks
            style = Qt.PenStyle.DashLine if line.dashed else Qt.PenStyle.SolidLine
            # a single long path is much slower, but segments restart dashes and show joints in thick lines
            self.setSegmentedLineMode("off" if line.dashed or alone else "on")
            self.setPen(pg.mkPen(line.colour, width=1.8 if alone else 1, style=style))
        self.setData(line.along, line.values)
        self.setVisible(True)


def text_background(colours: theme.Colours) -> QBrush:
    """Background of a text that curves may cross."""
    ground = QColor(colours.background)
    ground.setAlpha(170)
    return QBrush(ground)
