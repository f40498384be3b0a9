"""Slim colour bar in the strip over a picture, which it leaves free."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRect, QSize, Qt, Signal
from PySide6.QtGui import QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from ..base import theme
from .layers import Layer

_BAR = 4
"""Height of the gradient, below the labels of its ticks [px]."""
_TICK = 2
_GAP = 7
"""Minimum distance between labels [px]."""
_LEAST = 3
"""Minimum number of ticks, and the number of labels that the minimum width has room for."""
_MAX_TICKS = 9
_MAX_WIDTH = 280
_NO_LEVELS = -1000.0, 1000.0
"""The values whose labels set the width of a bar without values."""


class ColourBar(QWidget):
    """Gradient of a lookup table with labelled ticks above it, and the unit at the right; hidden without values.

    Ticks are at round numbers; where fewer than three of them have room, at both ends and in the middle.

    Signals
    -------
    resized()
        It needs another width, or was hidden or shown.
    """

    resized = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._unit = ""
        self.levels: tuple[float, float] | None = None
        """Values at the left and right end; None if the bar is hidden."""
        self._logarithmic = False
        self._gradient = QImage()
        self.value: float | None = None
        """The marked value."""
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def show_layer(self, layer: Layer, unit: str = "") -> None:
        """Show the scale of a layer's values; hide the bar if it has none."""
        shown = layer.has_values
        self.show_scale(layer.table, layer.levels if shown else None, unit, shown and layer.logarithmic)

    def show_scale(
        self, table: NDArray[np.uint8], levels: tuple[float, float] | None, unit: str, logarithmic: bool = False
    ) -> None:
        """Show a lookup table (256, 4), whose entries 1-255 run from the low to the high end, and the values there;
        None hides the bar. A logarithmic bar needs positive values."""
        row = np.ascontiguousarray(table[1:])
        self._gradient = QImage(row.data, len(row), 1, QImage.Format.Format_RGBA8888).copy()
        self.update()
        if (levels, unit, logarithmic) != (self.levels, self._unit, self._logarithmic):
            self.levels, self._unit, self._logarithmic = levels, unit, logarithmic
            self.resized.emit()

    def set_value(self, value: float | None) -> None:
        """Mark a value, in the bar's unit; None marks none."""
        if value != self.value:
            self.value = value
            if self.levels is not None:
                self.update()

    def sizeHint(self) -> QSize:
        """Width for as many ticks as are useful."""
        return QSize(_MAX_WIDTH, self.minimumSizeHint().height())

    def minimumSizeHint(self) -> QSize:
        """Width for three ticks and the unit."""
        metrics = self.fontMetrics()
        widest = max(metrics.horizontalAdvance(text) for text, _ in self._ends())
        return QSize(_LEAST * (widest + _GAP) + self._unit_width(), metrics.ascent() + _TICK + _BAR)

    @property
    def ticks(self) -> list[tuple[str, float]]:
        """Texts of the ticks, and their positions on the bar, 0-1 from the left."""
        if self.levels is None:
            return []
        for count in range(_MAX_TICKS, _LEAST - 1, -1):
            ticks = (log_ticks if self._logarithmic else linear_ticks)(*self.levels, count)
            places = [self._label(text, share) for text, share in ticks]
            has_room = all(left.right() + _GAP <= right.left() for left, right in pairwise(places))
            if len(ticks) >= _LEAST and has_room:
                return ticks
        return self._ends()

    def _ends(self) -> list[tuple[str, float]]:
        """Ticks at both ends and in the middle."""
        low, high = self.levels or _NO_LEVELS
        middle = math.sqrt(low * high) if self._logarithmic else (low + high) / 2
        return [(self._text(value), share) for value, share in ((low, 0.0), (middle, 0.5), (high, 1.0))]

    def _text(self, value: float) -> str:
        """Text of a value with as many decimals as the bar resolves."""
        if self._logarithmic:
            return tick_text(value, min(10.0 ** (math.floor(math.log10(max(value, 1e-2))) - 1), 1.0))
        low, high = self.levels or _NO_LEVELS
        return tick_text(value, max((high - low) / 100, 1e-3))

    def _unit_width(self) -> int:
        return self.fontMetrics().horizontalAdvance(f" {self._unit}")

    def _bar(self) -> QRect:
        """Rectangle of the gradient."""
        return QRect(0, self.height() - _BAR, self.width() - self._unit_width(), _BAR)

    def _at(self, share: float) -> int:
        """Horizontal position of a share of the gradient."""
        bar = self._bar()
        return bar.left() + round(share * (bar.width() - 1))

    def _label(self, text: str, share: float) -> QRect:
        """Rectangle of a text centred over its place, and within the gradient's ends."""
        bar, width = self._bar(), self.fontMetrics().horizontalAdvance(text)
        left = min(max(self._at(share) - width // 2, bar.left()), bar.right() + 1 - width)
        return QRect(left, 0, width + 1, bar.top() - _TICK)

    def paintEvent(self, event: QPaintEvent) -> None:
        if self.levels is None:
            return
        painter, colours, bar = QPainter(self), theme.colours(self.palette()), self._bar()
        painter.drawImage(bar, self._gradient)
        for text, share in self.ticks:
            x = self._at(share)
            painter.setPen(colours.grid)
            painter.drawLine(x, bar.top() - 1, x, bar.top())  # below a gap: a point would look like a comma
            painter.setPen(colours.text)
            self._write(painter, self._label(text, share), text)
        painter.setPen(colours.muted)
        self._write(painter, QRect(bar.right() + 1, 0, self._unit_width(), bar.top() - _TICK), f" {self._unit}")
        if self.value is not None:
            painter.setPen(colours.text)
            painter.drawRect(self._at(self._share(self.value)) - 2, bar.top() - 1, 4, _BAR)

    def _write(self, painter: QPainter, place: QRect, text: str) -> None:
        """Write digits at the bottom of a place, which has no room for descenders."""
        painter.drawText(place.left(), place.bottom(), text)

    def _share(self, value: float) -> float:
        """Position of a value on the bar, 0-1 from the left."""
        low, high = self.levels or _NO_LEVELS
        if self._logarithmic:
            value, low, high = math.log(max(value, low)), math.log(low), math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)


def linear_ticks(low: float, high: float, max_ticks: int) -> list[tuple[str, float]]:
    """Texts of ticks at multiples of 1, 2 or 5 times a power of ten, about as many as allowed, and their positions on
    the bar, 0-1 from the left."""
    power = 10.0 ** math.floor(math.log10((high - low) / max_ticks))
    step = next(factor * power for factor in (1, 2, 5, 10) if (high - low) / (factor * power) <= max_ticks)
    slack = step * 1e-6
    first, last = math.ceil((low - slack) / step), math.floor((high + slack) / step)
    ticks = [index * step for index in range(first, last + 1)]
    return [(tick_text(tick, step), (tick - low) / (high - low)) for tick in ticks]


def log_ticks(low: float, high: float, max_ticks: int) -> list[tuple[str, float]]:
    """The same for a logarithmic bar: ticks at 1, 2, 5 times powers of ten; fewer factors if there are too many."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    slack = 1 + 1e-6
    for factors in ((1, 2, 5), (1, 3), (1,)):
        ticks = [factor * 10.0**decade for decade in decades for factor in factors]
        ticks = [tick for tick in ticks if low / slack <= tick <= high * slack]
        if len(ticks) <= max_ticks:
            break
    length = math.log(high / low)
    return [(tick_text(tick, min(tick, 1.0)), math.log(tick / low) / length) for tick in ticks]


def tick_text(value: float, step: float) -> str:
    """Text of a number with the decimals that its step needs, and a true minus sign."""
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return f"{value:.{decimals}f}".replace("-", "\u2212")
