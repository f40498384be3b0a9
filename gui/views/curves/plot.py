"""Plots over iterations or time: a line for each curve, stage marks, the colour-weighted span and a cursor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QFont

from ...base import theme
from .axes import paint_plot, set_title
from .curve import Values

NAMED_AXIS, AXIS, _BARE = 34, 20, 6
"""Heights of the horizontal axis [px]: with name, with numbers only, and bare."""

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
    width: float


class Label(NamedTuple):
    """A straight line across a plot, at a value (angle 0) or at a position of the axis (90), with a text at it."""

    at: float
    angle: int
    text: str
    colour: QColor


_TEXT_PLACE = {
    # below the line at the left, where no curve is before it has converged; and at the top
    0: {"position": 0.02, "anchors": [(0, 0), (0, 0)], "movable": False},
    90: {"position": 0.97, "anchors": [(0, 0), (1, 0)], "movable": False},
}


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
    span_name : str
        Name of the span, written in the plot.

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

    def __init__(self, axis: pg.AxisItem, label: str, min_span: float = 0.0, span_name: str = "") -> None:
        super().__init__(viewBox=pg.ViewBox(enableMenu=False), axisItems={"left": axis}, enableMenu=False)
        self._label = label
        self.setAccessibleName(f"Plot: {label or 'errors'}")
        self._least_span = min_span
        self.lines: list[pg.PlotCurveItem] = []
        self.labels: list[pg.InfiniteLine] = []
        self._labelled: list[Label] | None = None
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
        self._span_name = pg.InfLineLabel(self._span.lines[0], span_name, position=0.01, anchors=[(0, 1), (0, 1)])
        self._span_name.setVisible(bool(span_name))
        self.addItem(self._points)
        self.plotItem.setContentsMargins(4, 7, 4, 2)
        self.hideButtons()
        view = self.getViewBox()
        view.setMouseEnabled(x=True, y=False)
        view.disableAutoRange()
        view.sigRangeChangedManually.connect(lambda *_: self.moved.emit(*view.viewRange()[0]))
        self.follows = True
        """Whether all iterations are in view."""
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

    def show_lines(self, lines: Sequence[Line], ends: tuple[float, float] | None = None) -> None:
        """Draw these lines and bring them into view: values between `ends`, or all; a line with a single value is drawn
        as a point."""
        while len(self.lines) < len(lines):
            self.lines.append(pg.PlotCurveItem(antialias=True, connect="finite"))
            self.addItem(self.lines[-1])
        for item, line in zip(self.lines, lines, strict=False):
            style = Qt.PenStyle.DashLine if line.dashed else Qt.PenStyle.SolidLine
            # a single long path is much slower, but segments restart dashes and show joints in thick lines
            item.setSegmentedLineMode("off" if line.dashed or line.width > 1 else "on")
            item.setData(line.along, line.values, pen=pg.mkPen(line.colour, width=line.width, style=style))
            item.setVisible(True)
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
            self._bring_into_view(lines, ends)

    def _bring_into_view(self, lines: Sequence[Line], ends: tuple[float, float] | None) -> None:
        if self.follows:
            begin = min(float(line.along[0]) for line in lines)
            end = max(self._min_end, *(float(line.along[-1]) for line in lines))
            self._show_range(0, *_widened(0.0 if begin <= end / 4 else begin, end))
        marked = [label.at for label in self._labelled or () if label.angle == 0]
        values = np.concatenate([*(line.values for line in lines), marked] if ends is None else [ends])
        if np.isfinite(values).any():
            low, high = float(np.nanmin(values)), float(np.nanmax(values))
            # room for a line of text above and below, and below what is marked
            room = 0.12 * (high - low) + max(self._least_span - (high - low), 0.0) / 2 or 0.5
            top = high + room
            bottoms = [low - room, *(mark - self._text_share * (top - mark) for mark in marked)]
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

    def show_labels(self, labels: Sequence[Label]) -> None:
        """Draw these labelled lines; values at which they are, are in view with the next lines."""
        if labels == self._labelled:
            return
        self._labelled = list(labels)
        for line in self.labels:
            self.removeItem(line)
        self.labels.clear()
        for label in labels:
            dashed = {"width": 1.5, "style": Qt.PenStyle.DashLine}
            pen = pg.mkPen(label.colour, **({"width": 1} if label.angle else dashed))
            line = pg.InfiniteLine(label.at, label.angle, pen, label=label.text, labelOpts=_TEXT_PLACE[label.angle])
            line.setZValue(5)  # its text stays readable over the curves
            self._paint_text(line.label, label.colour)
            self.labels.append(line)
            self.addItem(line, ignoreBounds=True)

    def _paint_text(self, text: pg.InfLineLabel, colour: QColor) -> None:
        text.setColor(colour)
        text.setFont(self._font)
        text.fill = pg.mkBrush(theme.faded(self._colours.background, 170))  # curves may cross it

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
        """Apply the theme's colours, to marks and labels when they are shown next."""
        self._colours, self._font = colours, font
        paint_plot(self, colours, font)
        self._stage_pen = pg.mkPen(colours.grid)
        self._marked = self._labelled = None
        self._span.setBrush(theme.faded(colours.accent, 28))
        self._cursor.setPen(pg.mkPen(colours.muted))
        self._paint_text(self._span_name, colours.muted)
        for name, text in (("left", self._label), ("bottom", self._places)):
            set_title(
                self.getAxis(name), text, color=colours.muted.name(), **{"font-size": f"{font.pointSizeF():.1f}pt"}
            )

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit_requested.emit()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(math.nan)

    def _mouse_moved(self, position: QPointF) -> None:
        self.hovered.emit(self.getViewBox().mapSceneToView(position).x())


def _widened(low: float, high: float) -> tuple[float, float]:
    """Widen a range to round ends, so that it does not change with every new value."""
    step = 2.0 ** (math.floor(math.log2(max(high - low, 1e-9))) - 3)
    return math.floor(low / step) * step, math.ceil(high / step) * step
