"""Slim vertical colour bar over a picture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QWidget

from ..base.theme import Colours

_BAR = 8
_PAD = 5
_TICK = 3
_PLATE_ALPHA = 190
"""Opacity (0-255) of the plate between the picture and the ticks."""


class ColourBar(QWidget):
    """Gradient of a lookup table with labelled ticks at round numbers and the unit on top.

    It has a translucent plate, so that the ticks are readable on any picture, and ignores the mouse.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._unit = ""
        self._levels: tuple[float, float] | None = None
        self._logarithmic = False
        self._gradient = QImage()
        self._colours: Colours | None = None
        self._faded = False
        self._value: float | None = None
        self._drawn: QPixmap | None = None
        """The bar without the marked value."""
        font = self.font()
        font.setPointSizeF(font.pointSizeF() * 0.85)
        self.setFont(font)
        self._fit_width()
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)

    def set_colours(self, colours: Colours) -> None:
        """Apply the theme's colours."""
        self._colours = colours
        self._redraw()

    def set_unit(self, unit: str) -> None:
        """Set the unit of the values, shown above the bar."""
        self._unit = unit
        self._redraw()

    def set_table(self, table: NDArray[np.uint8]) -> None:
        """Set the lookup table (256, 4); entries 1-255 run from the low to the high end."""
        column = np.ascontiguousarray(table[:0:-1])
        self._gradient = QImage(column.data, 1, len(column), 4, QImage.Format.Format_RGBA8888).copy()
        self._redraw()

    def set_levels(self, levels: tuple[float, float] | None, logarithmic: bool = False) -> None:
        """Set the values at the lower and upper end, in the bar's unit; None draws nothing.

        A logarithmic bar needs positive values.
        """
        if (levels, logarithmic) != (self._levels, self._logarithmic):
            self._levels, self._logarithmic = levels, logarithmic
            self._fit_width()
            self._redraw()

    def set_value(self, value: float | None) -> None:
        """Mark a value, in the bar's unit; None marks none."""
        if value != self._value:
            before, self._value = self._marked(), value
            if self._levels is not None:
                self.update(before)
                self.update(self._marked())

    @property
    def levels(self) -> tuple[float, float] | None:
        """Values at the lower and upper end; None if nothing is drawn."""
        return self._levels

    @property
    def value(self) -> float | None:
        """The marked value."""
        return self._value

    def set_faded(self, faded: bool) -> None:
        """Hide the bar, so that the picture below is visible, or show it again."""
        if faded != self._faded:
            self._faded = faded
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._colours is None or self._levels is None or self._faded:
            return
        size, ratio = self.size(), self.devicePixelRatioF()
        if self._drawn is None or self._drawn.size() != size * ratio:
            self._drawn = QPixmap(size * ratio)
            self._drawn.setDevicePixelRatio(ratio)
            self._drawn.fill(Qt.GlobalColor.transparent)
            self._paint_scale(QPainter(self._drawn), self._colours, self._levels)
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._drawn)
        if self._value is not None:
            painter.setFont(self.font())
            self._paint_value(painter, self._colours, self._value, self._levels)

    def _fit_width(self) -> None:
        """Be as narrow as the texts at the ends and between them allow; the right side stays in its place."""
        texts = ["\u22120000"] if self._levels is None else [_number(level, self._levels) for level in self._levels]
        if self._logarithmic and self._levels is not None:
            texts = [_significant(level) for level in self._levels]
        text = max(self.fontMetrics().horizontalAdvance(text) for text in texts)
        width, right = _PAD + _BAR + _TICK + 3 + text + 3, self.x() + self.width()
        if width != self.width():
            self.setFixedWidth(width)
            self.move(right - width, self.y())

    def _redraw(self) -> None:
        """Redraw the scale."""
        self._drawn = None
        self.update()

    def _paint_scale(self, painter: QPainter, colours: Colours, levels: tuple[float, float]) -> None:
        painter.setFont(self.font())
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        plate = QColor(colours.background)
        plate.setAlpha(_PLATE_ALPHA)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(plate)
        painter.drawRoundedRect(self.rect(), 4, 4)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        line, bar = self.fontMetrics().height(), self._bar()
        if bar.height() < 2 * line:
            return
        painter.setPen(colours.text)
        painter.drawText(_PAD, _PAD + self.fontMetrics().ascent(), self._unit)
        painter.drawImage(bar, self._gradient)
        painter.drawRect(bar.adjusted(0, 0, -1, -1))
        max_ticks = max(bar.height() // (2 * line), 2)
        for text, share in (log_ticks if self._logarithmic else linear_ticks)(*levels, max_ticks):
            y = _height_at(bar, share)
            painter.setPen(colours.muted)
            painter.drawLine(bar.right() + 1, y, bar.right() + _TICK, y)
            painter.setPen(colours.text)
            where = QRect(bar.right() + _TICK + 3, y - line, self.width(), 2 * line)
            painter.drawText(where, Qt.AlignmentFlag.AlignVCenter, text)

    def _bar(self) -> QRect:
        """Rectangle of the gradient."""
        line = self.fontMetrics().height()
        top = _PAD + line + line // 2
        return QRect(_PAD, top, _BAR, self.height() - top - _PAD - line // 2)

    def _marked(self) -> QRect:
        """Rectangle of the marked value; empty if there is none."""
        if self._value is None or self._levels is None:
            return QRect()
        line, y = self.fontMetrics().height(), _height_at(self._bar(), self._share(self._value, self._levels))
        return QRect(0, y - line // 2 - 1, self.width(), line + 2)

    def _share(self, value: float, levels: tuple[float, float]) -> float:
        """Position of a value on the bar, 0-1 from below."""
        low, high = levels
        if self._logarithmic:
            value, low, high = math.log(max(value, low)), math.log(low), math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def _paint_value(self, painter: QPainter, colours: Colours, value: float, levels: tuple[float, float]) -> None:
        place, bar = self._marked(), self._bar()
        y = place.center().y()
        painter.fillRect(place.adjusted(bar.right() + 1, 1, -1, -1), colours.background)
        painter.setPen(colours.text)
        painter.drawRect(bar.left() - 2, y - 2, _BAR + 3, 4)
        painter.setPen(colours.accent)
        text = _significant(value) if self._logarithmic else _number(value, levels)
        painter.drawText(place.adjusted(bar.right() + _TICK + 3, 0, 0, 0), Qt.AlignmentFlag.AlignVCenter, text)


def _height_at(bar: QRect, share: float) -> int:
    return bar.bottom() - round(share * (bar.height() - 1))


def _number(value: float, levels: tuple[float, float]) -> str:
    """Text of a value with as many decimals as the bar resolves."""
    return tick_text(value, max((levels[1] - levels[0]) / 100, 1e-3))


def _significant(value: float) -> str:
    """Text of a value with about two digits."""
    return tick_text(value, min(10.0 ** (math.floor(math.log10(max(value, 1e-2))) - 1), 1.0))


def linear_ticks(low: float, high: float, max_ticks: int) -> list[tuple[str, float]]:
    """Texts of ticks at round numbers, and their positions on the bar, 0-1 from below."""
    ticks, step = round_ticks(low, high, max_ticks)
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


def round_ticks(low: float, high: float, max_ticks: int) -> tuple[list[float], float]:
    """Multiples of 1, 2 or 5 times a power of ten between the ends, about as many as allowed, and their step."""
    power = 10.0 ** math.floor(math.log10((high - low) / max_ticks))
    step = next(factor * power for factor in (1, 2, 5, 10) if (high - low) / (factor * power) <= max_ticks)
    slack = step * 1e-6
    first, last = math.ceil((low - slack) / step), math.floor((high + slack) / step)
    return [index * step for index in range(first, last + 1)], step


def tick_text(value: float, step: float) -> str:
    """Text of a number with the decimals that its step needs, and a true minus sign."""
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return f"{value:.{decimals}f}".replace("-", "\u2212")
