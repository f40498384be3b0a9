"""Which depths of a cloud are drawn: a slider with two handles, in metres."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QToolButton, QWidget

from gui import theme
from gui.widgets.plain_text import PlainLabel

_HANDLE = 7.0
_STEP = 0.01
"""Of an arrow key, of the whole range; ten times that with Shift."""


class TwoHandles(QWidget):
    """A slider with two handles, both within 0-1. Arrows move the handle that was used last.

    Signals
    -------
    moved(float, float)
        Where the handles are now.
    """

    moved = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setMinimumWidth(80)
        self.values = [0.0, 1.0]
        self._present = 0
        self._held = False

    def set_values(self, low: float, high: float) -> None:
        """Put both handles somewhere, without a signal."""
        self.values = [low, high]
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(200, round(2 * _HANDLE) + 6)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = theme.colours(self.palette())
        y, left, right = self.height() / 2, *(self._place(value) for value in self.values)
        painter.setPen(QPen(colours.grid, 4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawLine(QPointF(self._place(0), y), QPointF(self._place(1), y))
        painter.setPen(QPen(colours.accent, 4))
        painter.drawLine(QPointF(left, y), QPointF(right, y))
        for number, x in enumerate((left, right)):
            painter.setPen(QPen(colours.accent if self.hasFocus() and number == self._present else colours.muted, 1.5))
            painter.setBrush(colours.background)
            painter.drawEllipse(QRectF(x - _HANDLE, y - _HANDLE, 2 * _HANDLE, 2 * _HANDLE))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        x = event.position().x()
        low, high = (self._place(value) for value in self.values)
        self._present = 0 if abs(x - low) < abs(x - high) or (low == high and x < low) else 1
        self._held = True
        self._move(self._value(x))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._held:
            self._move(self._value(event.position().x()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self._held = False

    def keyPressEvent(self, event: QKeyEvent) -> None:
        step = _STEP * (10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1)
        match event.key():
            case Qt.Key.Key_Left | Qt.Key.Key_Down:
                self._move(self.values[self._present] - step)
            case Qt.Key.Key_Right | Qt.Key.Key_Up:
                self._move(self.values[self._present] + step)
            case Qt.Key.Key_Space:
                self._present = 1 - self._present
                self.update()
            case _:
                super().keyPressEvent(event)

    def _move(self, value: float) -> None:
        """Move the present handle, up to the other."""
        low, high = (0.0, self.values[1]) if self._present == 0 else (self.values[0], 1.0)
        value = min(max(value, low), high)
        if value != self.values[self._present]:
            self.values[self._present] = value
            self.moved.emit(*self.values)
        self.update()

    def _place(self, value: float) -> float:
        return _HANDLE + 1 + value * (self.width() - 2 * _HANDLE - 2)

    def _value(self, x: float) -> float:
        return (x - _HANDLE - 1) / max(self.width() - 2 * _HANDLE - 2, 1.0)


class ClipRow(QWidget):
    """The slider with what its handles stand for, and a way back to all depths.

    Signals
    -------
    changed(float, float)
        Depths [m] between which the cloud is to be drawn; infinite where a handle is at its end.
    """

    changed = Signal(float, float)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._bounds = 0.0, 1.0
        self.depths = -math.inf, math.inf
        """Depths [m] that are drawn."""
        self._low, self._high = PlainLabel(), PlainLabel()
        self.slider = TwoHandles()
        self.slider.setAccessibleName("Depths that are drawn")
        self.slider.setToolTip("Drag a handle, or use the arrow keys; Space turns to the other one")
        self.slider.moved.connect(self._take)
        everything = QToolButton()
        everything.setText("All")
        everything.setAutoRaise(True)
        everything.setAccessibleName("Draw all depths")
        everything.setToolTip("Draw all depths again")
        everything.clicked.connect(self.clear)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 0, 8, 2)
        for widget in (PlainLabel("Depth"), self._low, self.slider, self._high, everything):
            layout.addWidget(widget)
        width = self.fontMetrics().horizontalAdvance("00.00 m")
        for label in (self._low, self._high):
            label.setFixedWidth(width)
            label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._show()

    def set_bounds(self, low: float, high: float) -> None:
        """Smallest and largest depth [m] of the cloud; what is cut off stays, in metres."""
        self._bounds = low, max(high, low + 1e-3)
        self._show()

    def clear(self) -> None:
        """Draw all depths."""
        self._set(-math.inf, math.inf)

    def _take(self, low: float, high: float) -> None:
        start, end = self._bounds
        nearest = start + low * (end - start) if low > 0 else -math.inf
        farthest = start + high * (end - start) if high < 1 else math.inf
        self._set(nearest, farthest)

    def _set(self, low: float, high: float) -> None:
        self.depths = low, high
        self._show()
        self.changed.emit(low, high)

    def _show(self) -> None:
        start, end = self._bounds
        low, high = (min(max(depth, start), end) for depth in self.depths)
        self._low.setText(f"{low:.2f} m")
        self._high.setText(f"{high:.2f} m")
        self.slider.set_values((low - start) / (end - start), (high - start) / (end - start))
