"""Depth along a line: raw depth, the result and what it is compared with; their plot, and its page."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QBuffer, QByteArray, QEvent, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QImage, QImageWriter, QPainter, QPainterPath, QResizeEvent
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import (
    QGraphicsPathItem,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ilf.evaluation.measuring import DepthProfile, Line, depth_profile

from ...base import theme
from ...state.document import Document
from ...state.results import ViewedIteration
from ...views.curves.axes import PointedPlot, paint_plot, set_title
from ...widgets.basics import Message, Themed, combo, lay_out, use_even_digits

Array = NDArray[np.floating]
Colour = tuple[int, int, int]

_RAW, _ERROR, _GROUND_TRUTH = "raw_m", "expected_error_m", "truth_m"


@dataclass(frozen=True, eq=False)
class DepthLine:
    """Depth [m] along the line, NaN = missing.

    Attributes
    ----------
    name : str
    depth : ndarray of float32, shape (N,)
    colour : (int, int, int) or None
        Colour of its run; None for one of the theme.
    is_reference : bool
        Whether it is ground truth.
    """

    name: str
    depth: NDArray[np.float32]
    colour: Colour | None = None
    is_reference: bool = False

    def drawn_in(self, colours: theme.Colours) -> QColor:
        """Return its colour in plot and legend."""
        if self.colour is not None:
            return QColor(*self.colour)
        return colours.text if self.is_reference else colours.series[0]


@dataclass(frozen=True, eq=False)
class ProfileData:
    """Depth along a line.

    Attributes
    ----------
    profile : DepthProfile
        Profile of the result, or of the raw depth if there is none, with all other maps.
    raw : ndarray of float32, shape (N,)
        Raw depth [m], NaN = missing.
    curves : tuple of DepthLine
        The result, the compared runs and ground truth, as far as there are any.
    error : ndarray of float32, shape (N,), or None
        Expected error [m] of the result, the first of the curves.
    labels : ndarray of int32, shape (N,)
        The block of each sample.
    names : mapping of int to str
        Names of these blocks.
    """

    profile: DepthProfile
    raw: NDArray[np.float32]
    curves: tuple[DepthLine, ...]
    error: NDArray[np.float32] | None
    labels: NDArray[np.int32]
    names: Mapping[int, str]

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
    called = [kept.name for kept in document.compared]
    names = [kept.name if called.count(kept.name) == 1 else f"{kept.name} #{kept.number}" for kept in document.compared]
    others |= {name: kept.completion.depth for name, kept in zip(names, document.compared, strict=True)}
    profile = depth_profile(frame.depth if result is None else result, *line, frame.intrinsics, others)
    found, curves = profile.others, []
    if result is not None:
        name = "result" if viewed_iteration is None else f"result {viewed_iteration.text}"
        curves.append(DepthLine(name, profile.depth))
    for name, kept in zip(names, document.compared, strict=True):
        curves.append(DepthLine(kept.name, found[name], kept.colour))
    if frame.ground_truth is not None:
        curves.append(DepthLine("ground truth", found[_GROUND_TRUTH], is_reference=True))
    labels = document.labels[profile.rows, profile.columns]
    blocks = {label: document.info(label).name for label in set(labels.tolist()) if label}
    return ProfileData(profile, found[_RAW], tuple(curves), found.get(_ERROR), labels, blocks)


_RAW_SIZE = 3.5
_SCALE = 2
"""Scale of a saved picture relative to the screen, per side."""
_LEFT, _BOTTOM = 52, 34
"""Fixed width and height of the axes [px], so that the plot stays still when their numbers grow."""


class ProfilePlot(PointedPlot):
    """Plot of raw depth as points; of the result with the band of its expected error and of others as lines."""

    def __init__(self) -> None:
        super().__init__()
        self._curves: list[pg.PlotCurveItem] = []
        self._raw = pg.ScatterPlotItem(size=_RAW_SIZE, pen=None, name="raw")
        self._band = QGraphicsPathItem()
        self._band.setPen(Qt.PenStyle.NoPen)
        self._borders = pg.VTickGroup(yrange=[0, 1])
        self.cursor_line.setZValue(99)
        for z, item in ((-20, self._borders), (-10, self._band)):
            item.setZValue(z)
            self.addItem(item, ignoreBounds=True)
        self.addItem(self._raw)
        self.plotItem.setContentsMargins(2, 6, 8, 2)
        for name in ("left", "bottom"):
            self.getAxis(name).setStyle(maxTickLevel=0, hideOverlappingLabels=True)
        self.getAxis("left").setWidth(_LEFT)
        self.getAxis("bottom").setHeight(_BOTTOM)
        self.setStatusTip("Wheel or drag: zoom and pan. Double-click: show the whole line.")
        self.setAccessibleName("Plot of the depth along the profile line")

    def show_data(self, data: ProfileData, x: Array, unit: str) -> None:
        """Draw data over positions `x` on the horizontal axis in `unit`; NaN where a sample has no position."""
        set_title(self.getAxis("bottom"), unit, color=self._colours.muted.name(), **self._label_font)
        known = np.isfinite(data.raw) & np.isfinite(x)
        self._raw.setData(x[known], data.raw[known])
        for item in self._curves:
            self.removeItem(item)
        self._curves = []
        for number, curve in enumerate(data.curves):
            style = Qt.PenStyle.DashLine if curve.is_reference else Qt.PenStyle.SolidLine
            pen = pg.mkPen(curve.drawn_in(self._colours), width=1.5 if number else 2, style=style)
            item = pg.PlotCurveItem(x, curve.depth, pen=pen, name=curve.name, antialias=True, connect="finite")
            item.setZValue(89 - number)
            self.addItem(item)
            self._curves.append(item)
        self._band.setPath(QPainterPath())
        if data.error is not None and data.curves:
            self._band.setPath(_band(x, data.curves[0].depth, data.error))
        edges = data.borders
        between = (x[edges] + x[edges - 1]) / 2
        self._borders.setXVals(between[np.isfinite(between)].tolist())

    def fit(self) -> None:
        """Show the whole line, also after changes of the data."""
        self.enableAutoRange(x=True, y=True)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Apply the theme's colours; those of the curves with the next data."""
        self._colours = colours
        self._label_font = {"font-size": f"{font.pointSizeF():.1f}pt"}
        paint_plot(self, colours, font)
        self._raw.setBrush(_raw_colour(colours))
        self._band.setBrush(theme.faded(colours.series[0], 54))
        self._borders.setPen(pg.mkPen(theme.faded(colours.muted, 110), width=1))
        self.cursor_line.setPen(pg.mkPen(colours.muted, width=1))
        set_title(self.getAxis("left"), "Depth [m]", color=colours.muted.name(), **self._label_font)

    def picture(self, as_svg: bool) -> bytes:
        """Return the plot with a legend as PNG, twice as large as on the screen, or as SVG."""
        legend = pg.LegendItem(offset=(-12, 8), labelTextColor=self._colours.text, verSpacing=-4)
        legend.setParentItem(self.getViewBox())
        for item in (self._raw, *self._curves):
            legend.addItem(item, item.name())
        pointed = self.cursor_line.isVisible()
        self.cursor_line.hide()
        self._raw.setExportMode(True)
        try:
            return self._drawn(as_svg)
        finally:
            self._raw.setExportMode(False)
            self.cursor_line.setVisible(pointed)
            self.scene().removeItem(legend)

    def _drawn(self, as_svg: bool) -> bytes:
        content = QBuffer()
        content.open(QBuffer.OpenModeFlag.WriteOnly)
        device: QSvgGenerator | QImage
        if as_svg:
            device = QSvgGenerator(QSvgGenerator.SvgVersion.Svg11)  # supports clipping
            device.setOutputDevice(content)
            device.setResolution(self.logicalDpiX())
            device.setSize(self.size())
            device.setViewBox(self.rect())
            device.setTitle("Depth along a line")
        else:
            device = QImage(self.size() * _SCALE, QImage.Format.Format_RGB32)
            device.setDevicePixelRatio(_SCALE)
        painter = QPainter(device)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self.render(painter, QRectF(self.viewport().rect()), self.viewport().rect())
        painter.end()
        if isinstance(device, QImage):
            QImageWriter(content, QByteArray(b"png")).write(device)
        return bytes(content.data().data())

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit()


def _raw_colour(colours: theme.Colours) -> QColor:
    """Return the colour of raw depth, in plot and legend."""
    return QColor("#c3c9d2") if colours.is_dark else QColor("#565e6a")


def _band(x: Array, depth: Array, error: Array) -> QPainterPath:
    """Return the area within the error around depth, in pieces where both are known."""
    path = QPainterPath()
    known = np.isfinite(x) & np.isfinite(depth) & np.isfinite(error)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]])))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        part = slice(start, stop)
        along = np.concatenate([x[part], x[part][::-1]])
        across = np.concatenate([depth[part] - error[part], (depth[part] + error[part])[::-1]])
        path.addPath(pg.arrayToQPath(along, across))
    return path


# The page of the panel.

_LONGEST_NAME = 130
"""Width [px] to which the name of a curve is elided in the legend."""
_DOT, _LINE, _DASHES = "●", "━", "┅"


class ProfilePage(Themed, QWidget):
    """Page with the depth along the profile line.

    Parameters
    ----------
    buttons : sequence of QWidget
        Beside the legend.

    Signals
    -------
    pointed(object)
        Number of the sample under the mouse, or None.
    """

    pointed = Signal(object)

    def __init__(self, buttons: Sequence[QWidget]) -> None:
        super().__init__()
        self.data: ProfileData | None = None
        """The plotted data; None for none."""
        self.sample: int | None = None
        """Number of the marked sample; None for none."""
        self._x: NDArray[np.float64] = np.zeros(0)
        self.plot = ProfilePlot()
        self.plot.hovered.connect(self._hover)
        top, rich = Qt.AlignmentFlag.AlignTop, Qt.TextFormat.RichText
        self.legend = QLabel(wordWrap=True, textFormat=rich, alignment=top)
        self.legend.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        hint = "Distance along the line: in pixels of the image, or in metres along the surface"
        self.axis = combo(["Pixels", "Metres"], hint, "Unit of the horizontal axis of the profile")
        self.axis.currentIndexChanged.connect(self._change_axis)
        header = lay_out(QHBoxLayout(), self.legend, margins=(8, 3, 4, 1), spacing=2, stretched=self.legend)
        for widget in (self.axis, *buttons):
            header.addWidget(widget, 0, Qt.AlignmentFlag.AlignTop)
        self._hint = Message()
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(self.plot)
        lay_out(QVBoxLayout(self), header, self._pages, spacing=0, stretched=self._pages)
        self._take_theme()

    def show_hint(self, text: str) -> None:
        """Show how to draw a line instead of a plot."""
        self.data = None
        self._hint.show_message(text)
        self._pages.setCurrentIndex(0)
        self.point_at(None)

    def show_data(self, data: ProfileData) -> None:
        """Plot depth."""
        self.data = data
        self._pages.setCurrentIndex(1)
        metres = data.profile.metres
        self.axis.setEnabled(metres is not None)
        if metres is not None and self.axis.currentIndex() == 1:
            self._x, unit = metres, "Along the surface from A to B [m]"
        else:
            self._x, unit = data.profile.pixels, "Along the line from A to B [px]"
        self.plot.show_data(data, self._x, unit)
        # the marked sample stays: its depth may change during a run
        self.point_at(self.sample if (self.sample or 0) < len(data.profile) else None)

    def point_at(self, sample: int | None) -> None:
        """Mark a sample in the plot and show its values; None for none."""
        self.sample = sample
        place = math.nan if sample is None else float(self._x[sample])
        self.plot.point_at(place if math.isfinite(place) else None)
        self.legend.setText("&nbsp;&nbsp; ".join(self._entries()))
        # as high as it was so far, so that the plot stays still while the mouse moves over it
        height = self.legend.heightForWidth(self.legend.width())
        self.legend.setMinimumHeight(max(height, self.legend.minimumHeight()))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.legend.setMinimumHeight(0)

    def _change_axis(self) -> None:
        self.plot.fit()
        self._show_again()

    def _show_again(self) -> None:
        if self.data is not None:
            self.show_data(self.data)

    def _hover(self, x: float) -> None:
        sample = None
        if self.data is not None and math.isfinite(x) and np.isfinite(self._x).any():
            sample = int(np.nanargmin(np.abs(self._x - x)))
        if sample != self.sample:
            self.point_at(sample)
            self.pointed.emit(sample)

    def _entries(self) -> list[str]:
        """The legend: where the marked sample is, and each curve with its value there."""
        data, n = self.data, self.sample
        if data is None:
            return []
        colours, metrics = theme.colours(self.palette()), self.fontMetrics()
        entries = []
        if n is not None:
            x, y, label = int(data.profile.columns[n]), int(data.profile.rows[n]), int(data.labels[n])
            block = html.escape(data.names.get(label, "no block")).replace(" ", "&nbsp;")
            entries.append(f"<span style='color:{colours.muted.name()}'>x&nbsp;{x}, y&nbsp;{y}&nbsp; {block}</span>")
        entries.append(_entry(_DOT, _raw_colour(colours), "raw", data.raw, n))
        for number, curve in enumerate(data.curves):
            mark = _DASHES if curve.is_reference else _LINE
            name = metrics.elidedText(curve.name, Qt.TextElideMode.ElideRight, _LONGEST_NAME)
            entry = _entry(mark, curve.drawn_in(colours), name, curve.depth, n)
            if n is not None and not number and data.error is not None and math.isfinite(data.error[n]):
                entry += f"&nbsp;±&nbsp;{1000 * data.error[n]:.0f}&nbsp;mm"
            entries.append(entry)
        return entries

    def _take_theme(self) -> None:
        small = QFont(self.font())
        small.setPointSizeF(small.pointSizeF() * 0.85)
        use_even_digits(self.legend)  # they keep it still
        self.plot.set_colours(theme.colours(self.palette()), small)
        self._show_again()


def _entry(mark: str, colour: QColor, name: str, depth: NDArray[np.float32], sample: int | None) -> str:
    """Return mark, name and value of a curve as HTML."""
    value = ""
    if sample is not None:
        value = f"&nbsp;{depth[sample]:.3f}&nbsp;m" if math.isfinite(depth[sample]) else "&nbsp;missing"
    name = html.escape(name).replace(" ", "&nbsp;")
    return f"<span style='color:{colour.name()}'>{mark}</span>&nbsp;{name}{value}"
