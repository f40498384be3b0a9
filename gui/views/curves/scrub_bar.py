"""A slider over the iterations of the last run: the views show the depth at the slider's iteration."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QSlider, QWidget

from ...widgets.basics import PlainLabel, flat_button, lay_out, use_even_digits


class ScrubBar(QWidget):
    """Slider over iterations, its position as text, and a button to its right end, the current depth.

    Signals
    -------
    moved(int)
        The user moved to an iteration; the last one is the current depth.
    """

    moved = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self._slider = QSlider(Qt.Orientation.Horizontal)
        self._slider.setMinimumWidth(60)
        self._slider.setAccessibleName("Iteration shown")
        self._slider.valueChanged.connect(self._report_position)
        self._text = PlainLabel()
        use_even_digits(self._text)
        hint = "Go to the last iteration, the current depth (End)"
        self._end = flat_button(hint, self.go_to_end, name="Go to the last iteration", icon="ph.skip-forward")
        parts = self._slider, self._text, self._end
        lay_out(QHBoxLayout(self), *parts, margins=(8, 0, 0, 2), spacing=4, stretched=self._slider)
        self.set_range(0)

    @property
    def position(self) -> int:
        """Iteration at the slider."""
        return self._slider.value()

    @property
    def last(self) -> int:
        """The last iteration; 0 if there are none."""
        return self._slider.maximum() if self._slider.isEnabled() else 0

    @property
    def at_end(self) -> bool:
        """Whether the slider is at its end, the current depth."""
        return self._slider.value() == self._slider.maximum()

    def set_range(self, last: int) -> None:
        """Set the range to iterations 1 to `last`, without a signal. A slider at its end stays there."""
        was_at_end = self.at_end
        with QSignalBlocker(self._slider):
            self._slider.setRange(1, max(last, 1))
            if was_at_end or last <= 1:
                self._slider.setValue(self._slider.maximum())
        self._slider.setPageStep(max(last // 10, 1))
        self._slider.setEnabled(last > 1)
        widest = f"i {last or 1} of {last or 1}"
        self._text.setMinimumWidth(self._text.fontMetrics().horizontalAdvance(widest))
        self._show()

    def set_hint(self, text: str) -> None:
        """Set the slider's tooltip."""
        self._slider.setToolTip(text)

    def go_to_end(self) -> None:
        """Go to the end, the current depth."""
        self._slider.setValue(self._slider.maximum())

    def _report_position(self, position: int) -> None:
        self._show()
        self.moved.emit(position)

    def _show(self) -> None:
        self._text.setText("current" if self.at_end else f"i {self.position} of {self._slider.maximum()}")
        self._text.setEnabled(self._slider.isEnabled())
        self._end.setEnabled(not self.at_end)
