"""The plot of depth along a line."""

from __future__ import annotations

import math

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QBuffer, QByteArray, QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QImage, QImageWriter, QPainter, QPainterPath
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QGraphicsPathItem

from gui import theme
from gui.inspect.dots import Dots
from gui.inspect.profile_data import ProfileData

Array = NDArray[np.floating]

_RAW_SIZE = 3.5
_SCALE = 2
"""Pixels of a saved picture per pixel of the screen, along one side."""
_LEFT, _BOTTOM = 52, 34
"""Width and height of the axes [px]: the plot does not jump when their numbers grow."""


class ProfilePlot(pg.PlotWidget):
    """Raw depth as points; the result with the band of its expected error, compared runs and truth as lines.

    Signals
    -------
    hovered(float)
        Place on the horizontal axis under the mouse, NaN when it leaves.
    """

    hovered = Signal(float)

    def __init__(self) -> None:
        super().__init__(viewBox=pg.ViewBox(enableMenu=False), enableMenu=False)
        self._band = QGraphicsPathItem()
        self._raw = Dots(_RAW_SIZE)
        self._result = _curve()
        self._truth = _curve()
        self._runs: list[pg.PlotCurveItem] = []
        self._borders = pg.VTickGroup(yrange=[0, 1])
        self._cursor = pg.InfiniteLine(angle=90)
        self._text = QColor()
        for z, item in ((-20, self._borders), (-10, self._band), (5, self._cursor)):
            item.setZValue(z)
            self.addItem(item, ignoreBounds=True)
        for z, item in ((0, self._raw), (1, self._truth), (3, self._result)):
            item.setZValue(z)
            self.addItem(item)
        self._cursor.hide()
        self.plotItem.setContentsMargins(2, 6, 8, 2)
        self.hideButtons()
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        for name in ("left", "bottom"):
            self.getAxis(name).enableAutoSIPrefix(False)
            self.getAxis(name).setStyle(maxTickLevel=0, hideOverlappingLabels=True)
        self.getAxis("left").setWidth(_LEFT)
        self.getAxis("bottom").setHeight(_BOTTOM)
        self.setStatusTip("Wheel or drag: zoom and move. Double-click: all of the line.")
        self.setAccessibleName("Plot of the depth along the profile line")
        self.scene().sigMouseMoved.connect(self._mouse_moved)

    def show_data(self, data: ProfileData, x: Array, unit: str) -> None:
        """Draw what there is over places on the horizontal axis, in some unit; NaN where a sample has none."""
        self.getAxis("bottom").setLabel(unit, color=self._muted, **self._label_font)
        known = np.isfinite(data.raw) & np.isfinite(x)
        self._raw.set_points(x[known], data.raw[known])
        _draw(self._result, x, data.result)
        _draw(self._truth, x, data.truth)
        for item in self._runs[len(data.runs) :]:
            self.removeItem(item)
        del self._runs[len(data.runs) :]
        while len(self._runs) < len(data.runs):
            item = _curve()
            item.setZValue(2)
            self.addItem(item)
            self._runs.append(item)
        for item, (_, colour, depth) in zip(self._runs, data.runs, strict=True):
            item.setPen(pg.mkPen(QColor(*colour), width=1.5))
            _draw(item, x, depth)
        self._band.setPath(_band(x, data.result, data.error))
        edges = data.borders
        between = (x[edges] + x[edges - 1]) / 2
        self._borders.setXVals(between[np.isfinite(between)].tolist())

    def clear_data(self) -> None:
        """Draw nothing."""
        for item in (self._result, self._truth, *self._runs):
            item.setData([], [])
        self._raw.set_points(np.zeros(0), np.zeros(0))
        self._band.setPath(QPainterPath())
        self._borders.setXVals([])

    def point_at(self, x: float) -> None:
        """Put the cursor at a place on the axis; NaN for nowhere."""
        self._cursor.setVisible(math.isfinite(x))
        if math.isfinite(x):
            self._cursor.setValue(x)

    def fit(self) -> None:
        """Show all of the line again, and go on doing so."""
        self.enableAutoRange(x=True, y=True)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Take the theme's colours."""
        self._text = colours.text
        self._muted = colours.muted.name()
        self._label_font = {"font-size": f"{font.pointSizeF():.1f}pt"}
        self.setBackground(colours.background)
        result = result_colour(colours)
        self._result.setPen(pg.mkPen(result, width=2))
        self._truth.setPen(pg.mkPen(colours.text, width=1.4, style=Qt.PenStyle.DashLine))
        self._raw.set_colour(raw_colour(colours))
        self._raw_sample = pg.ScatterPlotItem(size=2 * _RAW_SIZE, pen=None, brush=raw_colour(colours))
        tint = QColor(result)
        tint.setAlpha(54)
        self._band.setBrush(tint)
        self._band.setPen(QColor(0, 0, 0, 0))
        faint = QColor(colours.muted)
        faint.setAlpha(110)
        self._borders.setPen(pg.mkPen(faint, width=1))
        self._cursor.setPen(pg.mkPen(colours.muted, width=1))
        for name in ("left", "bottom"):
            axis = self.getAxis(name)
            axis.setPen(colours.grid)
            axis.setTextPen(colours.muted)
            axis.setTickFont(font)
        self.getAxis("left").setLabel("Depth [m]", color=self._muted, **self._label_font)

    def picture(self, names: list[tuple[str, str]], as_svg: bool) -> bytes:
        """The plot as PNG, twice as large as on the screen, or as SVG, with a legend of items ("raw", "result", "truth"
        or the number of a run) and their names."""
        items = {"raw": self._raw_sample, "result": self._result, "truth": self._truth}
        items |= {str(number): item for number, item in enumerate(self._runs)}
        legend = pg.LegendItem(offset=(-12, 8), labelTextColor=self._text, verSpacing=-4)
        legend.setParentItem(self.getViewBox())
        for key, name in names:
            legend.addItem(items[key], name)
        pointed = self._cursor.isVisible()
        self._cursor.hide()
        try:
            return self._svg() if as_svg else self._png()
        finally:
            self._cursor.setVisible(pointed)
            self.scene().removeItem(legend)

    def _svg(self) -> bytes:
        content = QBuffer()
        content.open(QBuffer.OpenModeFlag.WriteOnly)
        generator = QSvgGenerator(QSvgGenerator.SvgVersion.Svg11)  # which can clip
        generator.setOutputDevice(content)
        generator.setResolution(self.logicalDpiX())
        generator.setSize(self.size())
        generator.setViewBox(self.rect())
        generator.setTitle("Depth along a line")
        self._render(QPainter(generator))
        return bytes(content.data().data())

    def _png(self) -> bytes:
        image = QImage(self.size() * _SCALE, QImage.Format.Format_RGB32)
        image.setDevicePixelRatio(_SCALE)
        self._render(QPainter(image))
        content = QBuffer()
        content.open(QBuffer.OpenModeFlag.WriteOnly)
        QImageWriter(content, QByteArray(b"png")).write(image)
        return bytes(content.data().data())

    def _render(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.render(painter, QRectF(self.viewport().rect()), self.viewport().rect())
        painter.end()

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(math.nan)

    def _mouse_moved(self, position: QPointF) -> None:
        self.hovered.emit(self.getViewBox().mapSceneToView(position).x())


def result_colour(colours: theme.Colours) -> QColor:
    """Of the present result, in plot and legend."""
    return colours.series[0]


def raw_colour(colours: theme.Colours) -> QColor:
    """Of raw depth, in plot and legend."""
    return QColor("#c3c9d2") if colours.is_dark else QColor("#565e6a")


def _curve() -> pg.PlotCurveItem:
    return pg.PlotCurveItem(antialias=True, connect="finite")


def _draw(item: pg.PlotCurveItem, x: Array, depth: Array | None) -> None:
    if depth is None:
        item.setData([], [])
    else:
        item.setData(x, depth)


def _band(x: Array, depth: Array | None, error: Array | None) -> QPainterPath:
    """The area within an error around depth, piece by piece where both are known."""
    path = QPainterPath()
    if depth is None or error is None:
        return path
    known = np.isfinite(x) & np.isfinite(depth) & np.isfinite(error)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        part = slice(start, stop)
        along = np.concatenate([x[part], x[part][::-1]])
        across = np.concatenate([depth[part] - error[part], (depth[part] + error[part])[::-1]])
        path.addPath(pg.arrayToQPath(along, across))
    return path
