"""Plots over iterations or time: a line for each curve, stage marks, the colour-weighted span and a cursor."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QColor, QFont

from ...base import theme
from .axes import PointedPlot, paint_plot, set_title
from .curve import Values

NAMED_AXIS, AXIS, _BARE = 34, 20, 6
"""Heights of the horizontal axis [px]: with name, with numbers only, and bare."""

_MARK_ROW = 0.05
"""Height of the stage marks of one of several curves, as a share of the plot."""

_POINT = 6
"""Size of a curve that is a single point [px]."""


_TEXT_PLACE = {
    # below the line at the left, where no curve is before it has converged; and at the top
    0: {"position": 0.02, "anchors": [(0, 0), (0, 0)], "movable": False},
    90: {"position": 0.97, "anchors": [(0, 0), (1, 0)], "movable": False},
}


class ConvergencePlot(PointedPlot):
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
    moved(float, float)
        The user zoomed or panned the horizontal axis: its visible range.
    fit_requested()
        The user double-clicked to follow all iterations again.
    """

    moved = Signal(float, float)
    fit_requested = Signal()

    def __init__(self, axis: pg.AxisItem, label: str, min_span: float = 0.0, span_name: str = "") -> None:
        super().__init__(left=axis)
        self._label = label
        self.setAccessibleName(f"Plot: {label or 'errors'}")
        self._least_span = min_span
        self.lines: list[pg.PlotDataItem] = []
        self.labels: list[pg.InfiniteLine] = []
        self._stages: list[pg.VTickGroup] = []
        self._span = pg.LinearRegionItem(movable=False, pen=pg.mkPen(None))
        self._span.setZValue(-20)
        self._span.hide()
        self.addItem(self._span, ignoreBounds=True)
        self._span_name = pg.InfLineLabel(self._span.lines[0], span_name, position=0.01, anchors=[(0, 1), (0, 1)])
        self._span_name.setVisible(bool(span_name))
        self.plotItem.setContentsMargins(4, 7, 4, 2)
        view = self.getViewBox()
        view.setMouseEnabled(x=True, y=False)
        view.disableAutoRange()
        view.sigRangeChangedManually.connect(lambda *_: self.moved.emit(*view.viewRange()[0]))
        self.follows = True
        """Whether all iterations are in view."""
        self._ranges: dict[int, tuple[float, float]] = {}
        self.getAxis("bottom").setStyle(maxTickLevel=0)
        self.show_axis_labels(True)
        self.set_by_time(False)
        self.setStatusTip("Wheel or drag: zoom and pan along the iterations. Double-click: show all.")

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

    def draw(
        self,
        lines: Sequence[pg.PlotDataItem],
        stages: Sequence[Sequence[float]],
        span: tuple[float, float] | None,
        labels: Sequence[pg.InfiniteLine] = (),
        ends: tuple[float, float] | None = None,
    ) -> None:
        """Draw these lines, and bring them into view.

        Parameters
        ----------
        lines : sequence of PlotDataItem
            As from `drawn_line`.
        stages : sequence of sequence of float
            Starts of stages, of each line: marked over the full height if there is one, else in rows at the bottom.
        span : (float, float) or None
            The colour-weighted iterations, which are shaded.
        labels : sequence of InfiniteLine
            As from `straight_line`. Values at which they are, are in view, too.
        ends : (float, float), optional
            The values that are in view; all by default.
        """
        for item in (*self.lines, *self.labels, *self._stages):
            self.removeItem(item)
        self.lines, self.labels = list(lines), list(labels)
        self._stages = [self._ticks(row, places, len(stages) == 1) for row, places in enumerate(stages)]
        for item in (*self.lines, *self.labels, *self._stages):
            self.addItem(item, ignoreBounds=True)
        for line in self.labels:
            self._paint_text(line.label, line.pen.color())
        self._span.setVisible(span is not None)
        if span is not None:
            self._span.setRegion(span)
        if lines:
            marked = [line.value() for line in labels if line.angle == 0]
            self._bring_into_view(marked, ends)

    def _ticks(self, row: int, places: Sequence[float], alone: bool) -> pg.VTickGroup:
        height = [0, 1] if alone else [row * _MARK_ROW, (row + 0.8) * _MARK_ROW]
        colour = self._colours.grid if alone else self.lines[row].opts["pen"].color()
        group = pg.VTickGroup(list(places), height, pg.mkPen(colour))
        group.setZValue(-10)
        return group

    def _bring_into_view(self, marked: Sequence[float], ends: tuple[float, float] | None) -> None:
        if self.follows:
            begin = min(float(line.xData[0]) for line in self.lines)
            end = max(self._min_end, *(float(line.xData[-1]) for line in self.lines))
            self._show_range(0, *_widened(0.0 if begin <= end / 4 else begin, end))
        values = np.concatenate([*(line.yData for line in self.lines), marked] if ends is None else [ends])
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

    def _paint_text(self, text: pg.InfLineLabel, colour: QColor) -> None:
        text.setColor(colour)
        text.setFont(self._font)
        text.fill = pg.mkBrush(theme.faded(self._colours.background, 170))  # curves may cross it

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
        """Apply the theme's colours, to what is drawn when it is drawn next."""
        self._colours, self._font = colours, font
        paint_plot(self, colours, font)
        self._span.setBrush(theme.faded(colours.accent, 28))
        self.cursor_line.setPen(pg.mkPen(colours.muted))
        self._paint_text(self._span_name, colours.muted)
        for name, text in (("left", self._label), ("bottom", self._places)):
            set_title(
                self.getAxis(name), text, color=colours.muted.name(), **{"font-size": f"{font.pointSizeF():.1f}pt"}
            )

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit_requested.emit()


def drawn_line(
    along: Values, values: Values, colour: QColor, dashed: bool = False, width: float = 1
) -> pg.PlotDataItem:
    """Return a curve to draw: positions along the axis, and values there, NaN for none; a single one is a point."""
    pen = pg.mkPen(colour, width=width, style=Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine)
    item = pg.PlotDataItem(along, values, pen=pen, connect="finite", antialias=True)
    # a single long path is much slower, but segments restart dashes and show joints in thick lines
    item.curve.setSegmentedLineMode("off" if dashed or width > 1 else "on")
    if np.count_nonzero(np.isfinite(values)) == 1:
        item.setSymbol("o")
        item.setSymbolSize(_POINT)
        item.setSymbolPen(None)
        item.setSymbolBrush(colour)
    return item


def straight_line(at: float, angle: int, text: str, colour: QColor) -> pg.InfiniteLine:
    """Return a line across a plot to draw, at a value (angle 0) or a position of the axis (90), with a text at it."""
    dashed = {"width": 1.5, "style": Qt.PenStyle.DashLine}
    pen = pg.mkPen(colour, **({"width": 1} if angle else dashed))
    line = pg.InfiniteLine(at, angle, pen, label=text, labelOpts=_TEXT_PLACE[angle])
    line.setZValue(5)  # its text stays readable over the curves
    return line


def _widened(low: float, high: float) -> tuple[float, float]:
    """Widen a range to round ends, so that it does not change with every new value."""
    step = 2.0 ** (math.floor(math.log2(max(high - low, 1e-9))) - 3)
    return math.floor(low / step) * step, math.ceil(high / step) * step
