"""The colour range: its panel and its commands."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QStackedWidget, QVBoxLayout, QWidget

from ..base import theme
from ..base.commands import command
from ..base.needs import Need
from ..state.parts import Part
from ..views.colours import FIXED, KINDS, MODES, Levels, Range
from ..views.curves.axes import Plot, paint_plot
from ..widgets.basics import PlainLabel, Themed, combo, command_button, lay_out
from ..widgets.docks import PanelGroup
from .context import Context
from .panel import Panel

# A histogram with the two limits of the colour range, which can be dragged.

_BINS = 120
_SHOWN = 0.5, 99.5
"""Percentiles of the values that the axis covers; it always covers the levels."""
_MARGIN = 0.04
_AXIS_HEIGHT = 20
_MIN_LOG_VALUE = 1e-3


class Histogram(Themed, Plot):
    """Counts of values on a linear or a logarithmic axis.

    Signals
    -------
    levelsDragged(float, float)
        The user has moved a level.
    """

    levelsDragged = Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self._logarithmic = self._symmetric = False
        self._curve = pg.PlotCurveItem([0.0, 1.0], [0.0], stepMode="center", fillLevel=0)
        self._region = pg.LinearRegionItem(swapMode="block")
        self._region.setZValue(10)
        self.addItem(self._curve)
        self.addItem(self._region, ignoreBounds=True)
        self.hideAxis("left")
        self.getViewBox().setMouseEnabled(x=False, y=False)
        self.getAxis("bottom").setHeight(_AXIS_HEIGHT)
        self.setMinimumHeight(90)
        self.setAccessibleName("Histogram of the shown values")
        self.setToolTip("Frequency of each value. Drag the lines to set the limits of the colour range")
        self._region.sigRegionChanged.connect(self._drag)
        self._region.sigRegionChangeFinished.connect(self._drag)
        self._take_theme()

    @property
    def levels(self) -> Levels:
        """Positions of the two lines."""
        low, high = self._region.getRegion()
        return (10.0**low, 10.0**high) if self._logarithmic else (float(low), float(high))

    def show_values(self, values: NDArray[np.floating] | None, levels: Levels, kind: str, locked: bool) -> None:
        """Draw the histogram of values (NaN is ignored) of a kind, and place the two lines; not while they are dragged.

        The axis of errors is logarithmic; levels of differences are symmetric around 0.
        """
        self._logarithmic, self._symmetric = kind == "expected", kind == "signed"
        self.getAxis("bottom").setLogMode(self._logarithmic)
        self._region.setMovable(not locked)
        if any(line.moving for line in self._region.lines):
            return
        ends = self._on_axis(np.array(levels, float))
        known = np.zeros(0) if values is None else self._on_axis(values[np.isfinite(values)].astype(float))
        low, high = ends
        if known.size:
            lowest, highest = np.percentile(known, _SHOWN)
            low, high = min(low, float(lowest)), max(high, float(highest))
        margin = _MARGIN * (high - low)
        counts, edges = np.histogram(known, _BINS, (low - margin, high + margin))
        # a value of many pixels, such as 0, would dwarf all others
        self._curve.setData(edges, np.sqrt(counts))
        self.setXRange(low - margin, high + margin, padding=0)
        self.setYRange(0, float(np.sqrt(counts.max(initial=1))), padding=0.05)
        with QSignalBlocker(self._region):
            self._region.setRegion(tuple(ends))

    def _take_theme(self) -> None:
        colours, font = theme.colours(self.palette()), self.font()
        font.setPointSizeF(font.pointSizeF() * 0.85)
        paint_plot(self, colours, font)
        self._curve.setPen(pg.mkPen(colours.muted))
        self._curve.setBrush(theme.faded(colours.muted, 90))
        self._region.setBrush(theme.faded(colours.accent, 36))
        for line in self._region.lines:
            line.setPen(pg.mkPen(colours.accent, width=2))
            line.setHoverPen(pg.mkPen(colours.accent, width=4))

    def _on_axis(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.log10(np.maximum(values, _MIN_LOG_VALUE)) if self._logarithmic else values

    def _drag(self) -> None:
        if self._symmetric:
            low, high = self._region.getRegion()
            moved = next((line.value() for line in self._region.lines if line.moving), None)
            far = abs(moved) if moved is not None else (high - low) / 2
            with QSignalBlocker(self._region):
                self._region.setRegion((-far, far))
        low, high = self._region.getRegion()
        if low < high:
            self.levelsDragged.emit(*self.levels)


_DECIMALS = {"depth": 3, "signed": 2, "expected": 2}
_LARGEST = 1e6
_NO_RANGE = "Click a view of depth, a difference or an error"

_ROBUST = 1, 99
"""Percentiles of the values at the ends of a range that is set from them."""


def range_of(values: NDArray[np.floating], kind: str) -> Levels | None:
    """Return the ends of a colour range for values (NaN is ignored), symmetric around 0 for differences; None if all
    are equal.

    Examples
    --------
    >>> range_of(np.array([1.0, 2.0, np.nan, 3.0]), "depth")
    (1.02, 2.98)
    >>> range_of(np.array([-1.0, -1.0]), "signed")
    (-1.0, 1.0)
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return None
    if kind == "signed":
        known = np.concatenate((np.abs(known), -np.abs(known)))
    low, high = (round(float(level), 9) for level in np.percentile(known, _ROBUST))
    return (low, high) if low < high else None


class ColourRange(Panel):
    """Colour range of the active view; one range for all depths, one for all differences and errors."""

    title = "Range"
    icon = "ph.chart-bar"
    group = PanelGroup.INSPECTION
    parts = Part.FRAME | Part.RESULTS | Part.EXPECTED_ERROR | Part.COMPARED | Part.GROUND_TRUTH
    deferred = Part.SOME_RESULTS | Part.PREVIEWS

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        views = context.views
        context.refresh.add("range_lock", self._show_lock, Part.FRAME, also=(views.rangeChanged, views.shownChanged))
        self._show_lock()

    @command("show_range", "Colour &range", icon="ph.chart-bar", keys="Ctrl+Shift+G")
    def _open(self) -> None:
        """Open the histogram of the shown values with the limits of the colour range."""
        self.context.panels.enter(self.title)

    def make(self) -> QWidget:
        actions, views = self.context.actions, self.views
        for signal in (views.rangeChanged, views.shownChanged):
            signal.connect(self.redraw)
        self.kind = ""
        """Kind of the range shown; "" for none."""
        self.histogram = Histogram()
        self.histogram.levelsDragged.connect(self._set_levels)
        self.heading = PlainLabel()
        self.mode = combo(MODES, "How the range is computed: robust leaves out 1 % of the values at each end")
        self.mode.setAccessibleName("Range mode")
        self.mode.activated.connect(self._set_mode)
        self.low, self.high = (self._number(f"{end} limit of the colour range") for end in ("Lower", "Upper"))
        nothing = PlainLabel(_NO_RANGE, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
        self._pages = QStackedWidget()
        self._pages.addWidget(self.histogram)
        self._pages.addWidget(nothing)
        buttons = (command_button(actions[name]) for name in ("fit_range", "lock_range"))
        top = lay_out(QHBoxLayout(), self.heading, *buttons, stretched=self.heading)
        bottom = lay_out(QHBoxLayout(), self.mode, self.low, PlainLabel("\N{EN DASH}"), self.high, None)
        panel = QWidget()
        lay_out(QVBoxLayout(panel), top, self._pages, bottom, margins=(6, 4, 6, 4), spacing=4, stretched=self._pages)
        return panel

    def _number(self, hint: str) -> QDoubleSpinBox:
        number = QDoubleSpinBox(minimum=-_LARGEST, maximum=_LARGEST)
        number.setKeyboardTracking(False)
        number.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        number.setToolTip(hint)
        number.setAccessibleName(hint)
        number.valueChanged.connect(lambda _: self._type(number))
        return number

    def refresh(self, parts: Part) -> None:
        """Show the range of the active view, or why there is none."""
        ranges, cell, levels = self.views.ranges, self.views.ranged, self._levels
        self.kind = kind = "" if levels is None else cell.range_kind
        self.heading.setText(f"{cell.strip.title} [{KINDS[kind]}]" if kind else cell.strip.title)
        self._pages.setCurrentIndex(int(levels is None))
        if levels is not None:
            self._show_range(ranges.of(kind), levels)
        for widget in (self.mode, self.low, self.high):
            widget.setEnabled(bool(kind) and not ranges.of(kind).locked)

    def _show_range(self, one: Range, levels: Levels) -> None:
        """Show the range of the present kind over the values of the view."""
        self.histogram.show_values(self.views.ranged.view.values(), levels, self.kind, one.locked)
        self.mode.setCurrentIndex(self.mode.findData(one.mode))
        for number, level in zip((self.low, self.high), levels, strict=True):
            with QSignalBlocker(number):
                number.setDecimals(_DECIMALS[self.kind])
                number.setSuffix(f" {KINDS[self.kind]}")
                number.setValue(level)

    def _type(self, field: QDoubleSpinBox) -> None:
        """Apply a typed number; in a range symmetric around 0, adapt the other one."""
        low, high = self.low.value(), self.high.value()
        if self.kind == "signed":
            far = abs(field.value())
            low, high = -far, far
        if self.kind:
            self.mode.setCurrentIndex(self.mode.findData(FIXED))
            self._set_levels(low, high)

    @property
    def _levels(self) -> Levels | None:
        """The range of the active view; None if it has none now."""
        cell = self.views.ranged
        return cell.bar.levels if self.workspace.shown is not None and cell.range_kind else None

    def _why_no_range(self) -> str:
        return "" if self._levels is not None else "Not available now."

    def _show_lock(self) -> None:
        """Show whether the range is locked."""
        views, lock = self.views, self.context.actions["lock_range"]
        with QSignalBlocker(lock):
            lock.setChecked(self._levels is not None and views.ranges.of(views.ranged.range_kind).locked)

    @command(
        "fit_range",
        "Colour range from selection or view",
        icon="ph.arrows-out-line-vertical",
        keys="Ctrl+Alt+G",
        needs=Need.FRAME,
        why_off=_why_no_range,
    )
    def fit(self) -> None:
        """Set the colour range to the values of the selected blocks, or of the visible part of the view."""
        cell, document = self.views.ranged, self.workspace.current
        kind, box = cell.range_kind, cell.view.visible_box()
        of_blocks = cell.view.values(np.isin(document.labels, document.selected))
        found = None if of_blocks is None else range_of(of_blocks, kind)
        where = "the view" if found is None else "the selected blocks"
        seen = cell.view.values(box) if found is None else None
        levels = range_of(seen, kind) if seen is not None else found
        if levels is None:
            self.notes.show_message(f"{cell.strip.title} has no different values in the view.")
            return
        self.views.ranges.set(kind, FIXED, levels, locked=False)
        self.notes.show_message(f"Colour range of {where}: {levels[0]:.4g} to {levels[1]:.4g} {KINDS[kind]}.")

    def _set_mode(self) -> None:
        cell, mode = self.views.ranged, self.mode.currentData()
        kind, levels = cell.range_kind, cell.bar.levels
        self.views.ranges.set(kind, mode, levels if mode == FIXED else None)

    def _set_levels(self, low: float, high: float) -> None:
        if low < high:
            self.views.ranges.set(self.views.ranged.range_kind, FIXED, (low, high))
        else:
            self.notes.show_message("The lower limit of the colour range must be below the upper one.")
            self.redraw()

    @command(
        "lock_range", "Loc&k colour range", icon="ph.lock", checkable=True, needs=Need.FRAME, why_off=_why_no_range
    )
    def _set_lock(self, on: bool) -> None:
        """Keep the colour range in all views, for all runs and frames."""
        kind, levels = self.views.ranged.range_kind, self.views.ranged.bar.levels
        if kind:
            self.views.ranges.set(kind, self.views.ranges.of(kind).mode, levels if on else None, locked=on)
