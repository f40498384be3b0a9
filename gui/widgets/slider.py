"""A slider for a parameter: which ones get it, and how its positions stand for values."""

from __future__ import annotations

import math

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QSlider

from ilf.declarations import Declaration, Value

_LINEAR_STEPS = 200
"""More steps than this cannot be told apart by hand."""

_LOG_STEPS = 240
_FINEST = 0.1
"""Smallest value above the left end of a logarithmic slider whose minimum is not above 0, in steps."""


def wants_slider(declaration: Declaration) -> bool:
    """Whether a slider makes sense: a number between two bounds that a hand can find its way between."""
    if declaration.choices or declaration.kind is bool or declaration.minimum is None or declaration.maximum is None:
        return False
    return declaration.scale == "log" or declaration.maximum - declaration.minimum <= _LINEAR_STEPS * declaration.step


class ValueScale:
    """Positions 0, 1, ..., `last` of a slider and the values they stand for: rising, whole numbers for an int.

    Parameters
    ----------
    declaration : Declaration
        One for which `wants_slider` holds.
    """

    def __init__(self, declaration: Declaration) -> None:
        self._kind = declaration.kind
        if declaration.minimum is None or declaration.maximum is None:
            raise ValueError(f"{declaration.name} has no bounds, which a slider needs")
        self._low, self._high = float(declaration.minimum), float(declaration.maximum)
        self._step = declaration.step
        self._log = declaration.scale == "log"
        if self._log:
            # what has no ratio to the rest, as 0, has a position of its own at the left end
            self._apart = int(self._low <= 0)
            finest = 1.0 if self._kind is int else _FINEST * self._step
            self._first = finest if self._apart else self._low
            self._decades = math.log10(self._high / self._first)
            self.last = _LOG_STEPS + self._apart
        else:
            self.last = max(round((self._high - self._low) / self._step), 1)

    def value(self, position: int) -> Value:
        """The value at a position, rounded as one would write it."""
        if position <= 0:
            found = self._low
        elif position >= self.last:
            found = self._high
        elif self._log:
            exponent = self._decades * (position - self._apart) / _LOG_STEPS
            found = float(f"{self._first * 10**exponent:.2g}")
        else:
            found = round(self._low + position * self._step, 9)
        found = min(max(found, self._low), self._high)
        return round(found) if self._kind is int else found

    def position(self, value: Value) -> int:
        """The position nearest to a value."""
        number = float(value)
        if not self._log:
            return round((number - self._low) / self._step)
        if number < self._first:
            return 0
        return self._apart + round(_LOG_STEPS * math.log10(number / self._first) / self._decades)


class ValueSlider(QSlider):
    """Slider over a `ValueScale`; `valueChanged` tells positions, `shown_value` what they stand for."""

    def __init__(self, declaration: Declaration) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self._scale = ValueScale(declaration)
        self.setRange(0, self._scale.last)
        self.setPageStep(max(self._scale.last // 10, 1))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    @property
    def shown_value(self) -> Value:
        """The value at the present position."""
        return self._scale.value(self.value())

    def show_value(self, value: Value) -> None:
        """Move to a value without a signal; a handle that already stands for it stays, also while it is dragged."""
        if self.shown_value != value:
            with QSignalBlocker(self):
                self.setValue(self._scale.position(value))
