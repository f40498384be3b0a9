"""Live convergence curves of one block: sigma_i with S_criteria, errors at known pixels, and the L1 norm."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFont, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLabel, QStackedWidget, QVBoxLayout, QWidget

from gui import theme
from ilf.filter.convergence import IterationRecord
from ilf.filter.edge_aware.record import EdgeAwareRecord
from ilf.filter.pass_band.record import PassBandRecord

from .convergence_plot import ConvergencePlot, ErrorPlot, veil

EMPTY_TEXT = "Run the filter to see how each block converges"
SIGMA_FLOOR = 1e-6
"""Smaller errors [m], zero included, are drawn here: a logarithmic axis has no zero."""

_SIDE_BY_SIDE = 1.7  # width over height from which the plots stand next to each other
_AXIS_WIDTH = 64
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

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        """Round values, thinned until the labels have room."""
        labels = max(size / _TICK_GAP, 1.0)
        spacing, values = super().tickValues(minVal, maxVal, size)[0]
        return [(spacing, values[:: math.ceil(len(values) / labels)])]

    def tickStrings(self, values: Sequence[float], scale: float, spacing: float) -> list[str]:
        digits = max(0, -math.floor(math.log10(spacing) + 1e-9))
        return [f"{value:.2e}" if abs(value) >= 1e7 else f"{value:,.{digits}f}" for value in values]


class CurvesPanel(QWidget):
    """The curves of one block, with linked iterations and a readout; errors if pixels are held out to tell them by.

    Signals
    -------
    shown()
        It can be seen again: what has come meanwhile is to be drawn.
    """

    shown = Signal()

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
        self.l1_plot = ConvergencePlot(SumAxis(), "L1 [m]")
        self.l1_plot.setXLink(self.sigma_plot)
        self.sigma_plot.getViewBox().setLimits(minYRange=1.2)
        self.error_plot = ErrorPlot(LengthAxis())
        self.error_plot.setXLink(self.sigma_plot)
        self._plots = (self.sigma_plot, self.error_plot, self.l1_plot)
        for plot in self._plots:
            plot.hovered.connect(self._hover)
        self._criterion_line = pg.InfiniteLine(
            angle=0, label="", labelOpts={"position": 0.02, "anchors": [(0, 1), (0, 1)], "movable": False}
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

    @property
    def hint(self) -> str:
        """Why there are no curves."""
        return self._hint.text()

    def set_hint(self, text: str = EMPTY_TEXT) -> None:
        """Say why there are no curves, where there are none."""
        self._hint.setText(text)

    def clear(self) -> None:
        """Show no block."""
        self._name = ""
        self.set_hint()
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
        sigma, residual, held_out = (
            _logarithms([getattr(record, name) for record in self.records])
            for name in ("sigma_i", "residual", "held_out")
        )
        l1 = np.array([record.l1 for record in self.records], np.float64)
        weighted = [record.i for record in self.records if isinstance(record, PassBandRecord) and record.weighted]
        span = (weighted[0] - 0.5, weighted[-1] + 0.5) if weighted else None
        self.sigma_plot.show_curve(iterations, sigma, self._stage_starts, span)
        self.error_plot.show_errors(iterations, held_out, residual, self._stage_starts, span)
        self.l1_plot.show_curve(iterations, l1, self._stage_starts, span)
        self._update_readout()

    def set_s_criteria(self, metres: float | None) -> None:
        """Draw the stop criterion of Eq. (1) [m] as a line; None: no line, as it has no part in the run."""
        self._criterion = metres
        self._criterion_line.setVisible(metres is not None)
        if metres is not None:
            self._criterion_line.setValue(math.log10(max(metres, SIGMA_FLOOR)))
            self._criterion_line.label.setFormat(f"S_criteria {length_text(metres)}")

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wide = self.width() > _SIDE_BY_SIDE * self.height()
        across, down = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        self._plots_layout.setDirection(across if wide else down)
        # stacked plots share the lowest one's iterations
        for plot in self._plots[:-1]:
            plot.show_iterations(wide)
        self._update_readout()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._refresh_theme()

    def _starts_stage(self, record: IterationRecord) -> bool:
        """Whether a stage begins after one of some length: where one begins every time there is nothing to mark."""
        if len(self.records) < 2:
            return False
        before, last = self.records[-2:]
        return record.stage != last.stage == before.stage

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
            *([f"hold-out {length_text(record.held_out)}"] if math.isfinite(record.held_out) else []),
            f"L1 {record.l1:,.4g} m" if record.l1 < 1e4 else f"L1 {record.l1:,.0f} m",
            *_own_facts(record),
            f"stage {record.stage}",
            f"residual {length_text(record.residual)}",
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
        sigma, l1, residual, held_out = colours.series
        self.sigma_plot.set_colours(colours, sigma, small)
        self.l1_plot.set_colours(colours, l1, small)
        self.error_plot.set_error_colours(colours, held_out, residual, small)
        self._criterion_line.setPen(pg.mkPen(colours.warning, width=1.5, style=Qt.PenStyle.DashLine))
        self._criterion_line.label.setColor(colours.warning)
        self._criterion_line.label.setFont(small)
        self._criterion_line.label.fill = veil(colours)
        self._hint.setStyleSheet(f"color: {colours.muted.name()};")


def _logarithms(metres: list[float]) -> np.ndarray:
    """log10 of lengths [m], those below the floor at the floor; NaN stays NaN."""
    return np.log10(np.maximum(np.array(metres, np.float64), SIGMA_FLOOR))


def _own_facts(record: IterationRecord) -> list[str]:
    """What a filter says of its iteration besides what all of them say."""
    if isinstance(record, PassBandRecord):
        return [f"radii {record.radii[0]:.1f} × {record.radii[1]:.1f}"]
    if isinstance(record, EdgeAwareRecord):
        return [f"cells {record.cell} px", *([f"round {record.round}"] if record.round else [])]
    return []
