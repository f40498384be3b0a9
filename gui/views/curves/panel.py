"""Live convergence curves of blocks and runs (sigma_i, errors, L1 norm), and a slider over iterations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QColor, QFont, QResizeEvent
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QStackedWidget, QVBoxLayout, QWidget

from ilf._runtime.formatting import length_text

from ...base import theme
from ...widgets.basics import PlainLabel, Themed, flat_button, lay_out
from .axes import LengthAxis, SumAxis
from .curve import FLOOR, Curve, legible
from .plot import AXIS, NAMED_AXIS, ConvergencePlot, drawn_line, straight_line
from .readout import Readout, numbers_of
from .scrub_bar import ScrubBar

EMPTY_TEXT = "Run the filter to see how each block converges"
_NO_TIMES = "The record of this run has no times: draw the curves over iterations, or run all blocks again"

_SIDE_BY_SIDE = 1.7  # width over height from which the plots are side by side
_MIN_PLOT_HEIGHT, _MIN_PLOT_WIDTH = 56, 180  # minimum size of a plot [px]; without room, the last plots are omitted
_NAMED_AXIS_HEIGHT = 250  # panel height [px] up to which axes have no name
_MIN_ROWS = 4  # minimum rows of the readout
_MIN_DECADES = 1.2  # minimum range in view
_HOLD_OUT_DECADES = 0.4  # range in view above the minimum hold-out error
_BY_TIME = "curves/by_time"
_TIME_HINT = "Plot the curves over the time since the start of each block, not over iterations"
_READOUT_HINT = (
    "i: iteration. σ: deviation sigma_i. err: error against ground truth: of the current depth, after the learned "
    "correction, as in the table of blocks; or of the depth at the iteration shown."
)
_ERROR_PLOT_HINT = (
    "Error against ground truth where depth was missing, after each iteration. The point at the end is the error "
    "after the learned correction, as in the table of blocks."
)


class CurvesPanel(Themed, QWidget):
    """The curves of some blocks and runs, with linked axes, a readout of all of them, and a slider over iterations.

    A single curve has the colours of the plots; several curves have their own colours. Whether they are over iterations
    or time is remembered.
    """

    def __init__(self) -> None:
        super().__init__()
        self._curves: list[Curve] = []
        self._arranged: object = None
        self._marks: tuple[list[list[float]], tuple[float, float] | None] = [], None
        """The starts of the stages of each curve, and the colour-weighted iterations of a single one."""
        self._hovered: float | None = None
        self._viewed_iteration: int | None = None
        self._by_time = bool(QSettings().value(_BY_TIME, False, type=bool))

        self._plots: tuple[ConvergencePlot, ...] = ()
        self.readout = Readout()
        self.readout.setToolTip(_READOUT_HINT)
        self.scrub_bar = ScrubBar()
        self._time_button = flat_button(_TIME_HINT, name="Curves over time", icon="ph.clock")
        self._time_button.setCheckable(True)
        self._time_button.setChecked(self._by_time)
        self._time_button.toggled.connect(self.set_by_time)

        plots = QWidget()
        self._plots_layout = lay_out(
            QBoxLayout(QBoxLayout.Direction.TopToBottom, plots), margins=(0, 0, 6, 0), spacing=0
        )
        body = QWidget()
        self._body_layout = lay_out(QVBoxLayout(body), self.readout, plots, stretched=plots, spacing=0)
        self._hint = PlainLabel(EMPTY_TEXT)
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._hint.setWordWrap(True)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(body)
        below = lay_out(
            QHBoxLayout(), self.scrub_bar, self._time_button, margins=(0, 0, 6, 0), spacing=2, stretched=self.scrub_bar
        )
        lay_out(QVBoxLayout(self), self._pages, below, spacing=0, stretched=self._pages)
        self.setMinimumSize(260, 120)
        self._show_axis()

    def _make_plots(self) -> None:
        """Make the plots, a fifth of what a window costs: only when there is something to draw."""
        self.sigma_plot = ConvergencePlot(LengthAxis(), "Deviation σ<sub>i</sub>", _MIN_DECADES)
        self.error_plot = ConvergencePlot(LengthAxis(), "Error", _MIN_DECADES)
        self.hold_out_plot = ConvergencePlot(LengthAxis(), "Hold-out")
        self.l1_plot = ConvergencePlot(SumAxis(), "L1 [m]", span_name="colour-weighted")
        self._plots = (self.sigma_plot, self.error_plot, self.hold_out_plot, self.l1_plot)
        names = "Deviation sigma_i", "Error against ground truth", "Hold-out error", "L1 norm"
        for plot, name in zip(self._plots, names, strict=True):
            plot.setAccessibleName(name)
            plot.hovered.connect(self._hover)
            plot.moved.connect(self._move_all)
            plot.fit_requested.connect(self._follow)
            self._plots_layout.addWidget(plot, 1)
        self.error_plot.setToolTip(_ERROR_PLOT_HINT)
        self._show_axis()

    # what is shown

    @property
    def hint(self) -> str:
        """Text shown while there are no curves."""
        return self._hint.text()

    def set_hint(self, text: str = EMPTY_TEXT) -> None:
        """Set the text shown while there are no curves."""
        self._hint.setText(text)

    def show_curves(self, curves: Sequence[Curve]) -> None:
        """Draw these curves."""
        styles = [[(curve.name, curve.colour, curve.dashed) for curve in some] for some in (curves, self._curves)]
        if styles[0] != styles[1]:
            self._hovered = None
            for plot in self._plots:
                plot.reset_ranges()
        self._curves = list(curves)
        self._draw()

    def set_by_time(self, on: bool) -> None:
        """Draw over time, or over iterations."""
        QSettings().setValue(_BY_TIME, on)
        self._by_time = on
        self._hovered = None
        self._show_axis()
        self._draw()

    def look_at(self, iteration: int | None) -> None:
        """Put the cursor at an iteration until the mouse moves it; None: the last one of each curve."""
        self._viewed_iteration = iteration
        self._update_readout()

    def _show_axis(self) -> None:
        self._time_button.setChecked(self._by_time)
        for plot in self._plots:
            plot.set_by_time(self._by_time)
            plot.reset_ranges()
        self._refresh_theme()

    def _follow(self) -> None:
        """Keep all iterations in view again."""
        for plot in self._plots:
            plot.reset_ranges()
        self._draw()

    def _move_all(self, low: float, high: float) -> None:
        """Show this part of the horizontal axis in all plots."""
        for plot in self._plots:
            plot.follows = False
            plot.setXRange(low, high, padding=0)

    @property
    def _drawn(self) -> list[Curve]:
        """The curves that have iterations and, over time, their times."""
        return [curve for curve in self._curves if curve.count and (curve.has_times or not self._by_time)]

    def _draw(self) -> None:
        curves = self._drawn
        if not curves and any(curve.count for curve in self._curves):
            self._hint.setText(_NO_TIMES)
        self._pages.setCurrentIndex(1 if curves else 0)
        if not self._plots:
            if not curves:
                return
            self._make_plots()
            self._arrange()
            for layout in (self._body_layout, self._plots_layout):  # ranges depend on the room that there is
                layout.activate()
        stages = [[curve.between(place, self._by_time) for place in curve.stages] for curve in curves]
        self._marks = stages, curves[0].weighted(self._by_time) if len(curves) == 1 else None
        series = theme.colours(self.palette())
        sigma, l1, residual, held_out = series.series
        self.sigma_plot.draw(self._lines("sigma_i", sigma), *self._marks, self._criteria(series.warning))
        self.l1_plot.set_label("L1 [m]" if len(curves) == 1 else "ΔL1 [%]")
        self.l1_plot.draw(self._lines("l1" if len(curves) == 1 else "l1_left", l1), *self._marks)
        if self._has("error"):
            self._draw_errors(series.error)
        if self._has("held_out"):
            self._draw_hold_outs(held_out, residual)
        self._arrange()
        self._update_readout()

    def _draw_errors(self, colour: QColor) -> None:
        """Draw the errors after the iterations, and as last points those after the correction."""
        lines = self._lines("error", colour)
        ends = [
            drawn_line(line.xData[-1:], np.log10(np.maximum([curve.corrected], FLOOR)), line.opts["pen"].color())
            for line, curve in zip(lines, self._drawn, strict=True)
            if math.isfinite(curve.corrected)
        ]
        self.error_plot.draw([*lines, *ends], *self._marks)

    def _draw_hold_outs(self, colour: QColor, residual: QColor) -> None:
        """Draw the hold-out errors; for a single curve also its errors at the other known pixels, and where its minimum
        is.

        The range is near the minimum: the first errors may be 100 times as large, and the rise after the minimum, which
        shows where noise begins, would be invisible beside them.
        """
        lines, more, labels, curves = self._lines("held_out", colour), [], [], self._drawn
        if len(curves) == 1:
            (line,), (curve,) = lines, curves
            least = int(np.nanargmin(line.yData))
            labels = [straight_line(float(line.xData[least]), 90, f"minimum at i = {curve.records[least].i}", colour)]
            more = self._lines("residual", residual, 1.4)
        minimum = float(np.nanmin(np.concatenate([line.yData for line in lines])))
        bottom = min([minimum, *(float(np.nanmin(one.yData)) for one in more)])
        self.hold_out_plot.draw([*more, *lines], *self._marks, labels, (bottom, minimum + _HOLD_OUT_DECADES))

    def _criteria(self, colour: QColor) -> list[pg.InfiniteLine]:
        """The stop criteria of Eq. (1), each with a remark; equal ones only once."""
        criteria = dict.fromkeys((curve.s_criteria, curve.remark) for curve in self._drawn)
        return [
            straight_line(
                math.log10(max(metres, FLOOR)),
                0,
                f"S_criteria {length_text(metres)}{f' ({remark})' if remark else ''}",
                colour,
            )
            for metres, remark in criteria
            if metres is not None
        ]

    def _has(self, quantity: str) -> bool:
        return any(curve.has(quantity) for curve in self._drawn)

    def _lines(self, quantity: str, colour: QColor, width: float = 1.8) -> list[pg.PlotDataItem]:
        """A line for every curve; a single one in the colour of the quantity, and of this width."""
        curves, is_dark = self._drawn, theme.is_dark(self.palette())
        alone = sum(curve.count > 1 for curve in curves) == 1
        return [
            drawn_line(
                curve.along(self._by_time),
                curve.values(quantity),
                colour if len(curves) == 1 else QColor(*legible(curve.colour, is_dark)),
                curve.dashed,
                width if alone else 1,
            )
            for curve in curves
        ]

    # room

    def _arrange(self) -> None:
        """Lay out the readout and the plots that fit."""
        if not self._plots:
            return
        there = True, self._has("error"), self._has("held_out"), True
        asked = self.size(), len(self._curves), there
        if asked == self._arranged:
            return
        self._arranged = asked
        wide = self.width() > max(_SIDE_BY_SIDE * self.height(), 2 * _MIN_PLOT_WIDTH)
        self._plots_layout.setDirection(QBoxLayout.Direction.LeftToRight if wide else QBoxLayout.Direction.TopToBottom)
        height = self.height() - self.scrub_bar.sizeHint().height()
        line = self.readout.fontMetrics().height() + 2
        max_rows = max(height // 3 // line, _MIN_ROWS)
        self.readout.set_max_rows(max_rows)
        if wide:
            fitting = self.width() // _MIN_PLOT_WIDTH
        else:
            axis = NAMED_AXIS if self.height() > _NAMED_AXIS_HEIGHT else AXIS
            fitting = (height - line * min(len(self._curves), max_rows) - axis) // _MIN_PLOT_HEIGHT
        by_weight = self.sigma_plot, self.l1_plot, self.error_plot, self.hold_out_plot
        has = dict(zip(self._plots, there, strict=True))
        fit = [plot for plot in by_weight if has[plot]][: max(fitting, 1)]
        wanted = [plot for plot in self._plots if plot in fit]
        for plot in self._plots:
            plot.setVisible(plot in wanted)
            # stacked plots share the axis of the lowest one
            plot.show_axis_labels(wide or plot is wanted[-1], self.height() > _NAMED_AXIS_HEIGHT)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    # reading

    def _hover(self, place: float) -> None:
        """Put the cursor at the iterations nearest to a position on the axis; NaN: none."""
        self._hovered = place if math.isfinite(place) else None
        self._update_readout()

    def _place(self, curve: Curve) -> int:
        """Index of a curve's iteration in the readout."""
        if self._hovered is not None:
            return curve.nearest(self._hovered, self._by_time)
        return curve.count - 1 if self._viewed_iteration is None else min(self._viewed_iteration, curve.count) - 1

    def _update_readout(self) -> None:
        """Show the numbers of the iterations under the cursor, or of the last ones."""
        curves = self._drawn
        pointing = bool(curves) and (self._hovered is not None or self._viewed_iteration is not None)
        cursor = None
        if pointing:
            longest = max(curves, key=lambda curve: curve.count)
            cursor = float(longest.along(self._by_time)[self._place(longest)])
        for plot in self._plots:
            plot.point_at(cursor)
        records = [curve.records[self._place(curve)] for curve in curves]
        if not pointing:  # the current depth has been corrected since
            records = [
                replace(record, error=curve.corrected) if math.isfinite(curve.corrected) else record
                for record, curve in zip(records, curves, strict=True)
            ]
        has = {quantity: self._has(quantity) for quantity in ("error", "held_out")}
        rows = [list(numbers_of(record, has, self._by_time, len(records) == 1)) for record in records]
        self.readout.show_rows(list(zip(curves, rows, strict=True)))

    # looks

    def _take_theme(self) -> None:
        self._refresh_theme()
        self._draw()

    def _refresh_theme(self) -> None:
        colours = theme.colours(self.palette())
        self._hint.setStyleSheet(f"color: {colours.muted.name()};")
        if not self._plots:
            return
        small = QFont(self.font())
        small.setPointSizeF(small.pointSizeF() * 0.85)
        _, _, residual, held_out = colours.series
        names = ((held_out, "Hold-out"), (residual, "residual"))  # in the colours of the curves
        texts = (f'<span style="color: {colour.name()}">{name}</span>' for colour, name in names)
        self.hold_out_plot.set_label(", ".join(texts))
        for plot in self._plots:
            plot.set_colours(colours, small)
