"""Plots over iterations: one curve with stage marks, the colour-weighted span and a cursor; and the errors' plot."""

from __future__ import annotations

import math

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Signal
from PySide6.QtGui import QBrush, QColor, QFont

from gui import theme

_AXIS_HEIGHT = 34
_ERROR_RANGE = 0.4
"""The errors' plot shows decades from the least hold-out error up to so many above it."""


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
        self.setAccessibleName(f"Plot: {label or 'errors'}")
        self._span_name: pg.InfLineLabel | None = None
        self.curve = pg.PlotCurveItem(antialias=True, connect="finite")
        self._stages = pg.VTickGroup(yrange=[0, 1])
        self._span = pg.LinearRegionItem(movable=False, pen=pg.mkPen(None))
        self._span.setZValue(-20)
        self._stages.setZValue(-10)
        self._cursor = pg.InfiniteLine(angle=90)
        for item in (self._span, self._stages, self._cursor):
            item.setVisible(False)
            self.addItem(item, ignoreBounds=True)
        self.addItem(self.curve)
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
        self.curve.setData(iterations, values)
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
        self.curve.setPen(pg.mkPen(curve, width=1.8))
        self._stages.setPen(pg.mkPen(colours.grid))
        tint = QColor(colours.accent)
        tint.setAlpha(28)
        self._span.setBrush(tint)
        self._cursor.setPen(pg.mkPen(colours.muted))
        if self._span_name is not None:
            self._span_name.setColor(colours.muted)
            self._span_name.setFont(font)
            self._span_name.fill = veil(colours)
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


class ErrorPlot(ConvergencePlot):
    """Errors at known pixels: of those held out of the iteration, with their least marked, and of the others.

    Its range is about the least hold-out error: the first errors may be 100 times as large, and the rise after the
    least, which tells where noise comes in, would be invisible beside them.
    """

    def __init__(self, axis: pg.AxisItem) -> None:
        super().__init__(axis, "")
        self.residual = pg.PlotCurveItem(antialias=True, connect="finite")
        self._least = pg.InfiniteLine(
            angle=90, label="", labelOpts={"position": 0.97, "anchors": [(0, 0), (1, 0)], "movable": False}
        )
        for item in (self.residual, self._least):
            self.addItem(item, ignoreBounds=True)
        self.hide()

    @property
    def least(self) -> int | None:
        """Iteration with the least hold-out error, which is marked; None if nothing is held out."""
        return None if self.isHidden() else int(self._least.value())

    def show_errors(
        self,
        iterations: np.ndarray,
        held_out: np.ndarray,
        residual: np.ndarray,
        stages: list[float],
        span: tuple[float, float] | None,
    ) -> None:
        """Draw both errors, log10 of metres over iterations, and marks as `show_curve`; hide if nothing is held out."""
        known = np.isfinite(held_out)
        self.setVisible(bool(known.any()))
        if not known.any():
            return
        self.show_curve(iterations, held_out, stages, span)
        self.residual.setData(iterations, residual)
        place = int(np.nanargmin(held_out))
        self._least.setValue(iterations[place])
        self._least.label.setFormat(f"least at i = {int(iterations[place])}")
        top = held_out[place] + _ERROR_RANGE
        bottom = min(held_out[place], np.nanmin(residual))
        self.getViewBox().setYRange(bottom, top, padding=0.1)

    def fit(self) -> None:
        self.enableAutoRange(x=True)

    def set_error_colours(self, colours: theme.Colours, held_out: QColor, residual: QColor, font: QFont) -> None:
        """Take the theme's colours. The axis says which curve is which."""
        names = ((held_out, "Hold-out"), (residual, "residual"))
        self._label = ", ".join(f'<span style="color: {colour.name()}">{name}</span>' for colour, name in names)
        self.set_colours(colours, held_out, font)
        self.residual.setPen(pg.mkPen(residual, width=1.4))
        self._least.setPen(pg.mkPen(held_out, width=1))
        self._least.label.setColor(held_out)
        self._least.label.setFont(font)
        self._least.label.fill = veil(colours)


def veil(colours: theme.Colours) -> QBrush:
    """Ground for a text that a curve may cross."""
    ground = QColor(colours.background)
    ground.setAlpha(170)
    return QBrush(ground)
