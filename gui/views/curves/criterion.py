"""The stop criterion of Eq. (1), as lines across a plot of deviations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QFont

from ilf._runtime.formatting import length_text

from ...base import theme
from .curve import FLOOR
from .plot import ConvergencePlot, text_background

_LABEL = {"position": 0.02, "anchors": [(0, 0), (0, 0)], "movable": False}
"""Below the line at the left, where no curve is before it has converged."""


class CriterionLines:
    """Labelled lines for the stop criteria of the shown blocks."""

    def __init__(self, plot: ConvergencePlot) -> None:
        self._plot = plot
        self._lines: list[pg.InfiniteLine] = []
        self._shown: list[tuple[float, str]] = []
        self._colours: theme.Colours | None = None
        self._font = QFont()

    @property
    def texts(self) -> list[str]:
        """Labels of the lines."""
        return [line.label.toPlainText() for line in self._lines]

    def show(self, criteria: Sequence[tuple[float, str]]) -> None:
        """Draw these criteria [m], each with a remark; equal ones only once."""
        different = list(dict.fromkeys(criteria))
        if different == self._shown:
            return
        self._shown = different
        self._plot.marked = [math.log10(max(metres, FLOOR)) for metres, _ in different]
        for line in self._lines:
            self._plot.removeItem(line)
        self._lines.clear()
        for place, (metres, remark) in zip(self._plot.marked, different, strict=True):
            text = f"S_criteria {length_text(metres)}{f' ({remark})' if remark else ''}"
            line = pg.InfiniteLine(place, angle=0, label=text, labelOpts=_LABEL)
            line.setZValue(5)  # its label stays readable over the curves
            self._lines.append(line)
            self._plot.addItem(line, ignoreBounds=True)
            self._paint(line)

    def set_colours(self, colours: theme.Colours, font: QFont) -> None:
        """Apply the theme's colours."""
        self._colours, self._font = colours, font
        for line in self._lines:
            self._paint(line)

    def _paint(self, line: pg.InfiniteLine) -> None:
        if self._colours is not None:
            line.setPen(pg.mkPen(self._colours.warning, width=1.5, style=Qt.PenStyle.DashLine))
            line.label.setColor(self._colours.warning)
            line.label.setFont(self._font)
            line.label.fill = text_background(self._colours)
