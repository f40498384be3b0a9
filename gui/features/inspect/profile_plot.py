"""Plot of depth along a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QBuffer, QByteArray, QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QImage, QImageWriter, QPaintEngine, QPainter, QPainterPath, QPen
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QGraphicsPathItem, QStyleOptionGraphicsItem, QWidget

from ilf.evaluation.measuring import DepthProfile, depth_profile
from ilf.project.run_history import StoredRun

from ...base import theme
from ...state.document import Document
from ...state.inspection import Line
from ...state.shown_depth import ViewedIteration

# Data along the profile line: raw depth, result, and what they are compared with.

Colour = tuple[int, int, int]

_RAW, _ERROR, _GROUND_TRUTH = "raw_m", "expected_error_m", "truth_m"


@dataclass(frozen=True, eq=False)
class ProfileData:
    """Depth along a line [m], NaN = missing; None for maps that do not exist.

    Attributes
    ----------
    profile : DepthProfile
        Profile of the result, or of the raw depth if there is none, with all other maps.
    raw : ndarray of float32, shape (N,)
    result, error, ground_truth : ndarray of float32, shape (N,), or None
        Completed depth, its expected error, and ground truth.
    name : str
        Name of the completed depth.
    runs : list of (str, (r, g, b), ndarray of float32)
        Name, colour and depth of the compared runs.
    labels : ndarray of int32, shape (N,)
        The block of each sample.
    """

    profile: DepthProfile
    raw: NDArray[np.float32]
    result: NDArray[np.float32] | None
    error: NDArray[np.float32] | None
    ground_truth: NDArray[np.float32] | None
    runs: list[tuple[str, Colour, NDArray[np.float32]]]
    labels: NDArray[np.int32]
    name: str = "result"

    @property
    def borders(self) -> NDArray[np.intp]:
        """Samples that belong to another block than the previous one."""
        return np.flatnonzero(np.diff(self.labels)) + 1


def profile_data(document: Document, line: Line, viewed_iteration: ViewedIteration | None = None) -> ProfileData:
    """Return the data of a frame along a line, with the current result or that of the iteration `viewed_iteration`,
    which has no expected error."""
    frame, result = document.frame, document.current_depth() if viewed_iteration is None else viewed_iteration.depth
    error = document.expected_error() if viewed_iteration is None else None
    maps = {_RAW: frame.depth, _ERROR: error, _GROUND_TRUTH: frame.ground_truth}
    others = {name: values for name, values in maps.items() if values is not None}
    names = _names(document.compared)
    others |= {name: kept.completion.depth for name, kept in zip(names, document.compared, strict=True)}
    profile = depth_profile(frame.depth if result is None else result, *line, frame.intrinsics, others)
    found = profile.others
    return ProfileData(
        profile,
        found[_RAW],
        None if result is None else profile.depth,
        found.get(_ERROR),
        found.get(_GROUND_TRUTH),
        [(kept.name, kept.colour, found[name]) for name, kept in zip(names, document.compared, strict=True)],
        document.labels[profile.rows, profile.columns],
        "result" if viewed_iteration is None else f"result {viewed_iteration.text}",
    )


def _names(runs: Sequence[StoredRun]) -> list[str]:
    """Return a unique name for each run."""
    names = [kept.name for kept in runs]
    return [kept.name if names.count(kept.name) == 1 else f"{kept.name} #{kept.number}" for kept in runs]


# Scatter item for many points of one colour.


class Dots(pg.GraphicsObject):
    """Points of constant size on the screen. On raster devices they consist of hairline points, which Qt draws fast
    enough for thousands of them during a drag.

    Parameters
    ----------
    size : float
        Diameter [px].
    """

    def __init__(self, size: float) -> None:
        super().__init__()
        self._size = size
        self._colour = QColor()
        self.x: NDArray[np.float64] = np.zeros(0)
        self.y: NDArray[np.float64] = np.zeros(0)
        self._rect = QRectF()

    def set_colour(self, colour: QColor) -> None:
        """Set the colour."""
        self._colour = colour
        self.update()

    def set_points(self, x: NDArray[np.floating], y: NDArray[np.floating]) -> None:
        """Set the points; all coordinates must be finite."""
        self.prepareGeometryChange()
        self.x, self.y = x.astype(np.float64), y.astype(np.float64)
        self._rect = QRectF()
        if x.size:
            self._rect.setCoords(self.x.min(), self.y.min(), self.x.max(), self.y.max())
        self.informViewBoundsChanged()
        self.update()

    def boundingRect(self) -> QRectF:
        return self._rect

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        to_screen = painter.worldTransform()
        x, y = self.x * to_screen.m11() + to_screen.dx(), self.y * to_screen.m22() + to_screen.dy()
        painter.resetTransform()
        if painter.paintEngine().type() == QPaintEngine.Type.Raster:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
            painter.setPen(QPen(self._colour, 0))
            x, y = (
                np.add.outer(offsets, values).ravel()
                for offsets, values in zip(self._offsets(painter), (x, y), strict=True)
            )
        else:
            painter.setPen(QPen(self._colour, self._size, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawPoints(pg.functions.arrayToQPolygonF(x, y))

    def _offsets(self, painter: QPainter) -> NDArray[np.float64]:
        """Return the offsets of a dot's device pixels from its centre, shape (2, N), without the corners."""
        ratio = painter.device().devicePixelRatioF()
        across = max(round(self._size * ratio), 1)
        steps = np.arange(across) - (across - 1) / 2
        places = np.array(np.meshgrid(steps, steps)).reshape(2, -1)
        return places[:, np.hypot(*places) <= across / 2 + 0.3] / ratio


Array = NDArray[np.floating]

_RAW_SIZE = 3.5
_SCALE = 2
"""Scale of a saved picture relative to the screen, per side."""
_LEFT, _BOTTOM = 52, 34
"""Fixed width and height of the axes [px], so that the plot stays still when their numbers grow."""


class ProfilePlot(pg.PlotWidget):
    """Plot of raw depth as points; result with the band of its expected error, compared runs and ground truth as lines.

    Signals
    -------
    hovered(float)
        Position on the horizontal axis under the mouse, NaN when the mouse leaves.
    """

    hovered = Signal(float)

    def __init__(self) -> None:
        super().__init__(viewBox=pg.ViewBox(enableMenu=False), enableMenu=False)
        self._band = QGraphicsPathItem()
        self._raw = Dots(_RAW_SIZE)
        self._result = _curve()
        self._ground_truth = _curve()
        self._runs: list[pg.PlotCurveItem] = []
        self._borders = pg.VTickGroup(yrange=[0, 1])
        self._cursor = pg.InfiniteLine(angle=90)
        self._text = QColor()
        for z, item in ((-20, self._borders), (-10, self._band), (5, self._cursor)):
            item.setZValue(z)
            self.addItem(item, ignoreBounds=True)
        for z, item in ((0, self._raw), (1, self._ground_truth), (3, self._result)):
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
        self.setStatusTip("Wheel or drag: zoom and pan. Double-click: show the whole line.")
        self.setAccessibleName("Plot of the depth along the profile line")
        self.scene().sigMouseMoved.connect(self._mouse_moved)

    def show_data(self, data: ProfileData, x: Array, unit: str) -> None:
        """Draw data over positions `x` on the horizontal axis in `unit`; NaN where a sample has no position."""
        self.getAxis("bottom").setLabel(unit, color=self._muted, **self._label_font)
        known = np.isfinite(data.raw) & np.isfinite(x)
        self._raw.set_points(x[known], data.raw[known])
        _draw(self._result, x, data.result)
        _draw(self._ground_truth, x, data.ground_truth)
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
        """Clear the plot."""
        for item in (self._result, self._ground_truth, *self._runs):
            item.setData([], [])
        self._raw.set_points(np.zeros(0), np.zeros(0))
        self._band.setPath(QPainterPath())
        self._borders.setXVals([])

    def point_at(self, x: float) -> None:
        """Set the cursor to a position on the axis; NaN hides it."""
        self._cursor.setVisible(math.isfinite(x))
        if math.isfinite(x):
            self._cursor.setValue(x)

    def fit(self) -> None:
        """Show the whole line, also after changes of the data."""
        self.enableAutoRange(x=True, y=True)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Apply the theme's colours."""
        self._text = colours.text
        self._muted = colours.muted.name()
        self._label_font = {"font-size": f"{font.pointSizeF():.1f}pt"}
        self.setBackground(colours.background)
        result = result_colour(colours)
        self._result.setPen(pg.mkPen(result, width=2))
        self._ground_truth.setPen(pg.mkPen(colours.text, width=1.4, style=Qt.PenStyle.DashLine))
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
        """Return the plot as PNG, twice as large as on the screen, or as SVG, with a legend of items ("raw", "result",
        "truth" or the number of a run) and their names."""
        items = {"raw": self._raw_sample, "result": self._result, "ground_truth": self._ground_truth}
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
        generator = QSvgGenerator(QSvgGenerator.SvgVersion.Svg11)  # supports clipping
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
    """Return the colour of the current result, in plot and legend."""
    return colours.series[0]


def raw_colour(colours: theme.Colours) -> QColor:
    """Return the colour of raw depth, in plot and legend."""
    return QColor("#c3c9d2") if colours.is_dark else QColor("#565e6a")


def _curve() -> pg.PlotCurveItem:
    return pg.PlotCurveItem(antialias=True, connect="finite")


def _draw(item: pg.PlotCurveItem, x: Array, depth: Array | None) -> None:
    if depth is None:
        item.setData([], [])
    else:
        item.setData(x, depth)


def _band(x: Array, depth: Array | None, error: Array | None) -> QPainterPath:
    """Return the area within the error around depth, in pieces where both are known."""
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
