"""A message for a short time, in the status bar, beside the views, which it neither covers nor moves; and the log."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QAccessibleEvent, QAction, QEnterEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QMainWindow, QToolButton

from ilf._runtime.termination import log_error

from .basics import ElidedLabel, flat_button, lay_out, without_flags
from .notices import LogPanel, ProblemBox, error_details, error_text

_SHARE = 0.6
"""Maximum width of a message, as a share of the status bar's: the hint for the mouse keeps the rest."""
_MIN_STAY_MS = 2000
"""Minimum time [ms] that a message stays after the pointer has left it."""


class Toast(QFrame):
    """A message in one line, with buttons for its commands, if any, and a close button. It never takes the focus, and
    stays for a time, longer while the pointer is over it.

    Signals
    -------
    gone()
        Its time is over, or it was closed.
    """

    gone = Signal()

    def __init__(self, message: str, milliseconds: int, actions: Sequence[QAction] = ()) -> None:
        super().__init__()
        self.setObjectName("toast")
        self.setStyleSheet(
            "#toast { background: palette(base); border: 1px solid palette(highlight); border-radius: 4px; }"
        )
        self.commands = [self._button(action) for action in actions]
        self.label = ElidedLabel(Qt.TextElideMode.ElideMiddle)
        self.close_button = flat_button("Close this message", self._go, icon="ph.x")
        row = lay_out(QHBoxLayout(self), self.label, margins=(6, 0, 1, 0), spacing=4, stretched=self.label)
        for button in (*self.commands, self.close_button):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            row.addWidget(button)
        self._over = QTimer(self, singleShot=True)
        self._over.timeout.connect(self._go)
        self.message = message
        self.label.setText(message)
        self.setAccessibleName(message)
        QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.Alert))
        self._over.start(milliseconds)

    def _button(self, action: QAction) -> QToolButton:
        button = QToolButton()
        button.setText(action.iconText().rstrip("…"))
        button.setToolTip(action.toolTip())
        button.clicked.connect(action.trigger)
        action.triggered.connect(self._go)  # also if it is triggered elsewhere
        return button

    def enterEvent(self, event: QEnterEvent) -> None:
        """Stay while the pointer is over it."""
        super().enterEvent(event)
        self._over.setInterval(max(self._over.remainingTime(), _MIN_STAY_MS))
        self._over.stop()

    def leaveEvent(self, event: QEvent) -> None:
        """Restart the timer."""
        super().leaveEvent(event)
        self._over.start()

    def _go(self) -> None:
        self._over.stop()
        self.gone.emit()


_MESSAGE_MS = 6000
_COMMAND_MS = 15_000


class Notes(QObject):
    """What the window says: the latest message for a short time, at the left of the status bar, and all in the log.

    Attributes
    ----------
    toast : Toast or None
        The message, until its time is over.

    Signals
    -------
    reported(str)
        The text of an error.
    """

    reported = Signal(str)

    def __init__(self, window: QMainWindow, log: LogPanel) -> None:
        super().__init__(window)
        self._window = window
        self._log = log
        self.toast: Toast | None = None

    @property
    def message(self) -> str:
        """Text of the visible message; "" for none."""
        return "" if self.toast is None else self.toast.message

    def show_message(self, message: str) -> None:
        """Show a message and add it to the log."""
        message = without_flags(message)
        self._show(message, _MESSAGE_MS)
        self._log.add(message)

    def offer(self, message: str, *actions: QAction) -> None:
        """Show a message with commands for a longer time, and add it to the log."""
        self._show(message, _COMMAND_MS, *actions)
        self._log.add(message)

    def warn(self, what: str, notes: Iterable[str], details: str = "") -> None:
        """Show notes on work that was done with restrictions, and log them; nothing if there are no notes."""
        texts = [without_flags(text) for text in notes]
        for text in texts:
            self._log.add(f"{what}: {text}")
        if texts:
            ProblemBox(what, "\n\n".join(texts), details, self._window).open()

    def report(self, what: str, error: Exception) -> None:
        """Show and log an error."""
        details = error_details(error)
        text = log_error(error) if details else error_text(error)
        self.warn(what, [text], details)
        self.reported.emit(f"{what}: {text}")

    def clear(self) -> None:
        """Remove the message."""
        if (toast := self.toast) is not None:
            self.toast = None
            toast.gone.disconnect(self.clear)
            self._window.statusBar().removeWidget(toast)
            toast.deleteLater()

    def _show(self, message: str, milliseconds: int, *actions: QAction) -> None:
        """Show a message in place of the one before."""
        self.clear()
        self.toast = toast = Toast(message, milliseconds, actions)
        toast.gone.connect(self.clear)
        toast.setMaximumWidth(round(_SHARE * self._window.width()))
        self._window.statusBar().insertWidget(0, toast)
        toast.show()
