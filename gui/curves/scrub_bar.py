"""A slider over the iterations of the last run: where it stands, the views show the depth as it was then."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFont, QKeyEvent
from PySide6.QtWidgets import QHBoxLayout, QSlider, QToolButton, QWidget

from gui import theme
from gui.widgets.plain_text import PlainLabel


class ScrubBar(QWidget):
    """Slider, what it stands at, and the way back to the present, which is its right end.

    Signals
    -------
    moved(int)
        The user has gone to an iteration; the last one is the present.
    """

    moved = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._slider = _Slider(Qt.Orientation.Horizontal)
        self._slider.setAccessibleName("Iteration to look back to")
        self._slider.valueChanged.connect(self._tell)
        self._text = PlainLabel()
        font = QFont(self.font())
        font.setFeature(QFont.Tag("tnum"), 1)
        self._text.setFont(font)
        self._end = QToolButton(autoRaise=True)
        self._end.setAccessibleName("Back to the present")
        self._end.setToolTip("Back to the present: what there is after the last iteration (Esc or End)")
        self._end.clicked.connect(self.go_to_end)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 0, 0, 2)
        layout.setSpacing(4)
        layout.addWidget(self._slider, 1)
        layout.addWidget(self._text)
        layout.addWidget(self._end)
        self.set_range(0)
        self._draw_icon()

    @property
    def position(self) -> int:
        """The iteration that it stands at."""
        return self._slider.value()

    @property
    def last(self) -> int:
        """The last iteration, which is the present; 0 if there are none."""
        return self._slider.maximum() if self._slider.isEnabled() else 0

    @property
    def at_end(self) -> bool:
        """Whether it stands at the present."""
        return self._slider.value() == self._slider.maximum()

    def set_range(self, last: int) -> None:
        """There are iterations from 1 up to this one. At the end it stays at the end; nobody is told."""
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
        """What the slider's tooltip says."""
        self._slider.setToolTip(text)

    def go_to_end(self) -> None:
        """Back to the present."""
        self._slider.setValue(self._slider.maximum())

    def _tell(self, position: int) -> None:
        self._show()
        self.moved.emit(position)

    def _show(self) -> None:
        self._text.setText("present" if self.at_end else f"i {self.position} of {self._slider.maximum()}")
        self._text.setEnabled(self._slider.isEnabled())
        self._end.setEnabled(not self.at_end)

    def _draw_icon(self) -> None:
        self._end.setIcon(theme.icon("ph.skip-forward", self.palette()))

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._draw_icon()


class _Slider(QSlider):
    """Goes to its end by Escape, as by End."""

    def __init__(self, orientation: Qt.Orientation) -> None:
        super().__init__(orientation)
        self.setMinimumWidth(60)

    def event(self, event: QEvent) -> bool:
        """Escape is the slider's own while it stands somewhere in the past."""
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.ShortcutOverride and self._escapes(event):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if self._escapes(event):
            self.setValue(self.maximum())
        else:
            super().keyPressEvent(event)

    def _escapes(self, event: QKeyEvent) -> bool:
        return event.key() == Qt.Key.Key_Escape and self.value() < self.maximum()
