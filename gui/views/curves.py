"""Live convergence curves of one block: sigma_i on a logarithmic axis with S_criteria, and the L1 norm."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFont, QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLabel, QStackedWidget, QVBoxLayout, QWidget

from ilf.filter.convergence import IterationRecord

from .. import theme

EMPTY_TEXT = "Run the filter to see how each block converges"
SIGMA_FLOOR = 1e-6
"""Smaller sigma_i [m], zero included, are drawn here: a logarithmic axis has no zero."""

_SIDE_BY_SIDE = 1.7  # width over height from which the plots stand next to each other
_AXIS_WIDTH = 64
_AXIS_HEIGHT = 34
_TICK_GAP = 17  # least distance between the labels of a vertical axis [px]


def length_text(metres: float) -> str:
    """A length with the unit that reads best, to three significant digits: 10 m, 100 mm, 0.1 mm, 1 µm."""
    if not math.isfinite(metres):
        return "–"
    size = abs(metres)
    if size >= 0.9995:
        scaled, unit = metres, "m"
    elif size >= 0.99e-4 or size == 0:
        scaled, unit = metres * 1e3, "mm"
    else:
        scaled, unit = metres * 1e6, "µm"
    text = f"{scaled:.3g}" if abs(scaled) < 999.5 else f"{scaled:,.0f}"
    return f"{text} {unit}"


class LengthAxis(pg.AxisItem):
    """Vertical axis whose values are log10 of metres and whose labels are lengths."""

    def __init__(self) -> None:
        super().__init__("left")
        self.enableAutoSIPrefix(False)
        self.setWidth(_AXIS_WIDTH)

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        """Whole decades, thinned until the labels have room; 1, 2, 5 where few decades are in view."""
        first, last = math.ceil(minVal - 1e-9), math.floor(maxVal + 1e-9)
        labels = max(size / _TICK_GAP, 1.0)
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


class SumAxis(pg.AxisItem):
    """Vertical axis for sums of metres: plain numbers with thousands separated, no unit prefix."""

    def __init__(self) -> None:
        super().__init__("left")
        self.enableAutoSIPrefix(False)
        self.setWidth(_AXIS_WIDTH)
        self.setStyle(maxTickLevel=0)

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        digits = max(0, -math.floor(math.log10(spacing) + 1e-9))
        return [f"{value:.2e}" if abs(value) >= 1e7 else f"{value:,.{digits}f}" for value in values]


class CurvesPanel(QWidget):
    """The two curves of one block, with linked iterations and a readout."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.records: list[IterationRecord] = []
        self._criterion: float | None = None
        self._stage_starts: list[float] = []
        self._hovered: int | None = None
        self._name = ""

        self._chip = QLabel()
        self._chip.setFixedSize(10, 10)
        self._title = QLabel()
        self._readout = QLabel()
        self._readout.setTextFormat(Qt.TextFormat.PlainText)
        self._readout.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        header = QHBoxLayout()
        header.setContentsMargins(8, 4, 8, 2)
        header.setSpacing(6)
        header.addWidget(self._chip)
        header.addWidget(self._title)
        header.addWidget(self._readout, 1)

        self.sigma_plot = ConvergencePlot(LengthAxis(), "Deviation σ<sub>i</sub>")
        self.l1_plot = ConvergencePlot(SumAxis(), "L1 norm of P<sub>i</sub> [m]")
        self.l1_plot.setXLink(self.sigma_plot)
        self.sigma_plot.getViewBox().setLimits(minYRange=1.2)
        self._plots = (self.sigma_plot, self.l1_plot)
        for plot in self._plots:
            plot.hovered.connect(self._hover)
        self._criterion_line = pg.InfiniteLine(
            angle=0, label="", labelOpts={"position": 0.98, "anchors": [(1, 1), (1, 1)], "movable": False}
        )
        self._criterion_line.setVisible(False)
        self.sigma_plot.addItem(self._criterion_line)
        self.l1_plot.name_span("colour-weighted")

        plots = QWidget()
        self._plots_layout = QBoxLayout(QBoxLayout.Direction.TopToBottom, plots)
        self._plots_layout.setContentsMargins(0, 0, 6, 0)
        self._plots_layout.setSpacing(0)
        for plot in self._plots:
            self._plots_layout.addWidget(plot, 1)
        self._hint = QLabel(EMPTY_TEXT)
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._hint.setWordWrap(True)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(plots)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(header)
        layout.addWidget(self._pages, 1)
        self.setMinimumSize(260, 120)
        self._chip.hide()
        self._refresh_theme()

    def set_block(self, label: int, name: str, colour: tuple[int, int, int]) -> None:
        """Show another block, without records yet.

        Parameters
        ----------
        label : int
            Label of the block in the label map.
        name : str
            What the user calls it; empty for its number.
        colour : tuple of int
            Red, green, blue of the block.
        """
        self._name = name or f"Block {label}"
        self._chip.setStyleSheet(f"background: rgb{tuple(colour)}; border-radius: 2px;")
        self._chip.show()
        self.set_records([])

    def clear(self) -> None:
        """Show no block."""
        self._name = ""
        self._chip.hide()
        self.set_records([])

    def set_records(self, records: Sequence[IterationRecord]) -> None:
        """Replace the curves."""
        self.records = []
        self._stage_starts = []
        self._hovered = None
        for plot in self._plots:
            plot.fit()
        self.append_records(records)

    def append_records(self, records: Sequence[IterationRecord]) -> None:
        """Add iterations at the end of the curves."""
        for record in records:
            if self._starts_stage(record):
                self._stage_starts.append(record.i - 0.5)
            self.records.append(record)
        self._pages.setCurrentIndex(1 if self.records else 0)
        iterations = np.array([record.i for record in self.records], np.float64)
        sigma = np.array([record.sigma_i for record in self.records], np.float64)
        l1 = np.array([record.l1 for record in self.records], np.float64)
        weighted = [record.i for record in self.records if record.weighted]
        span = (weighted[0] - 0.5, weighted[-1] + 0.5) if weighted else None
        self.sigma_plot.show_curve(iterations, np.log10(np.maximum(sigma, SIGMA_FLOOR)), self._stage_starts, span)
        self.l1_plot.show_curve(iterations, l1, self._stage_starts, span)
        self._update_readout()

    def set_s_criteria(self, metres: float | None) -> None:
        """Draw the stop criterion of Eq. (1) [m] as a line; None: no line, as it has no part in the run."""
        self._criterion = metres
        self._criterion_line.setVisible(metres is not None)
        if metres is not None:
            self._criterion_line.setValue(math.log10(max(metres, SIGMA_FLOOR)))
            self._criterion_line.label.setFormat(f"S_criteria {length_text(metres)}")

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wide = self.width() > _SIDE_BY_SIDE * self.height()
        across, down = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._plots_layout.setDirection(across if wide else down)
        # stacked plots share the lower one's iterations
        self.sigma_plot.show_iterations(wide)
        self._update_readout()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._refresh_theme()

    def _starts_stage(self, record: IterationRecord) -> bool:
        """Whether the pass band grew after it had been held: where it grows every time there are no stages."""
        if len(self.records) < 2:
            return False
        before, last = self.records[-2:]
        return (record.stage, record.radii) != (last.stage, last.radii) == (before.stage, before.radii)

    def _hover(self, iteration: float) -> None:
        """Point at the iteration nearest to a position on the axis; NaN: at none."""
        self._hovered = None
        if self.records and math.isfinite(iteration):
            offset = round(iteration) - self.records[0].i
            self._hovered = min(max(offset, 0), len(self.records) - 1)
        self._update_readout()

    def _update_readout(self) -> None:
        """Say the numbers of the iteration under the cursor, or else of the last one."""
        for plot in self._plots:
            plot.point_at(None if self._hovered is None else self.records[self._hovered].i)
        metrics = self.fontMetrics()
        self._title.setText(metrics.elidedText(self._name, Qt.TextElideMode.ElideRight, self.width() // 3))
        if not self.records:
            self._readout.clear()
            return
        record = self.records[-1 if self._hovered is None else self._hovered]
        parts = [
            f"i {record.i}",
            f"σ {length_text(record.sigma_i)}",
            f"L1 {record.l1:,.4g} m" if record.l1 < 1e4 else f"L1 {record.l1:,.0f} m",
            f"radii {record.radii[0]:.1f} × {record.radii[1]:.1f}",
            f"stage {record.stage}",
        ]
        room = self.width() - metrics.horizontalAdvance(self._title.text()) - 48
        while len(parts) > 2 and metrics.horizontalAdvance("   ".join(parts)) > room:
            parts.pop()
        self._readout.setText("   ".join(parts))

    def _refresh_theme(self) -> None:
        colours = theme.colours(self.palette())
        tabular = QFont(self.font())
        tabular.setFeature(QFont.Tag("tnum"), 1)  # figures of one width, or the readout trembles
        self._readout.setFont(tabular)
        small = QFont(self.font())
        small.setPointSizeF(small.pointSizeF() * 0.85)
        for plot, colour in zip(self._plots, colours.series, strict=False):
            plot.set_colours(colours, colour, small)
        self._criterion_line.setPen(pg.mkPen(colours.warning, width=1.5, style=Qt.PenStyle.DashLine))
        self._criterion_line.label.setColor(colours.warning)
        self._criterion_line.label.setFont(small)
        self._criterion_line.label.fill = _veil(colours)
        self._hint.setStyleSheet(f"color: {colours.muted.name()};")


class IterationView(pg.ViewBox):
    """View with little padding along the iterations, and room for a line of text above and below the curve."""

    def suggestPadding(self, axis: int) -> float:
        return 0.02 if axis == self.XAxis else 0.12


class ConvergencePlot(pg.PlotWidget):
    """A curve over iterations with stage marks, the colour-weighted span and a cursor."""

    hovered = Signal(float)
    """Iteration under the mouse, NaN when it leaves."""

    def __init__(self, axis: pg.AxisItem, label: str) -> None:
        super().__init__(viewBox=IterationView(enableMenu=False), axisItems={"left": axis}, enableMenu=False)
        self._label = label
        self._span_name: pg.InfLineLabel | None = None
        self._curve = pg.PlotCurveItem(antialias=True, connect="finite")
        self._stages = pg.VTickGroup(yrange=[0, 1])
        self._span = pg.LinearRegionItem(movable=False, pen=pg.mkPen(None))
        self._span.setZValue(-20)
        self._stages.setZValue(-10)
        self._cursor = pg.InfiniteLine(angle=90)
        for item in (self._span, self._stages, self._cursor):
            item.setVisible(False)
            self.addItem(item, ignoreBounds=True)
        self.addItem(self._curve)
        self.plotItem.setContentsMargins(4, 7, 4, 2)
        self.hideButtons()
        view = self.getViewBox()
        view.setMouseEnabled(x=True, y=False)
        view.setLimits(xMin=0, minXRange=10)
        self.getAxis("bottom").enableAutoSIPrefix(False)
        self.getAxis("bottom").setStyle(maxTickLevel=0)
        self.show_iterations(True)
        self.setFrameShape(pg.PlotWidget.Shape.NoFrame)
        self.setStatusTip("Wheel or drag: zoom and move along the iterations. Double-click: all of them.")
        self.scene().sigMouseMoved.connect(self._mouse_moved)

    def show_curve(
        self, iterations: np.ndarray, values: np.ndarray, stages: list[float], span: tuple[float, float] | None
    ) -> None:
        """Draw values over iterations, marks between stages and the span of colour-weighted iterations."""
        self._curve.setData(iterations, values)
        self._stages.setVisible(bool(stages))
        self._stages.setXVals(stages)
        self._span.setVisible(span is not None)
        if span is not None:
            self._span.setRegion(span)

    def name_span(self, text: str) -> None:
        """Say in the plot what the shaded span means."""
        self._span_name = pg.InfLineLabel(self._span.lines[0], text, position=0.01, anchors=[(0, 1), (0, 1)])

    def point_at(self, iteration: int | None) -> None:
        """Put the cursor on an iteration, or nowhere."""
        self._cursor.setVisible(iteration is not None)
        if iteration is not None:
            self._cursor.setValue(iteration)

    def fit(self) -> None:
        """Follow all iterations again."""
        self.enableAutoRange(x=True, y=True)

    def show_iterations(self, shown: bool) -> None:
        """Label the horizontal axis, or leave only its line."""
        axis = self.getAxis("bottom")
        axis.setStyle(showValues=shown)
        axis.showLabel(shown)
        axis.setHeight(_AXIS_HEIGHT if shown else 6)

    def set_colours(self, colours: theme.Colours, curve: QColor, font: QFont) -> None:
        """Take the theme's colours, one of them for the curve."""
        self.setBackground(colours.background)
        self._curve.setPen(pg.mkPen(curve, width=1.8))
        self._stages.setPen(pg.mkPen(colours.grid))
        veil = QColor(colours.accent)
        veil.setAlpha(28)
        self._span.setBrush(veil)
        self._cursor.setPen(pg.mkPen(colours.muted))
        if self._span_name is not None:
            self._span_name.setColor(colours.muted)
            self._span_name.setFont(font)
            self._span_name.fill = _veil(colours)
        for name, text in (("left", self._label), ("bottom", "Iteration i")):
            axis = self.getAxis(name)
            axis.setPen(colours.grid)
            axis.setTextPen(colours.muted)
            axis.setTickFont(font)
            axis.setLabel(text, color=colours.muted.name(), **{"font-size": f"{font.pointSizeF():.1f}pt"})

    def mouseDoubleClickEvent(self, event: QEvent) -> None:
        self.fit()

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(math.nan)

    def _mouse_moved(self, position: QPointF) -> None:
        self.hovered.emit(self.getViewBox().mapSceneToView(position).x())


def _veil(colours: theme.Colours) -> QBrush:
    """Ground for a text that a curve may cross."""
    ground = QColor(colours.background)
    ground.setAlpha(170)
    return QBrush(ground)
