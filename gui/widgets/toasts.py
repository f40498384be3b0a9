"""Messages for a short time, in the status bar: beside the views, which they neither cover nor move."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QAccessibleEvent, QAction, QEnterEvent
from PySide6.QtWidgets import QFrame, QHBoxLayout, QMainWindow, QToolButton

from ..base import theme
from .basics import ElidedLabel, Themed, flat_button, lay_out

MAX_TOASTS = 3
"""Maximum number of messages at a time; a new one replaces the oldest."""

_SHARE = 0.6
"""Maximum width of a message, as a share of the status bar's: the hint for the mouse keeps the rest."""
_MIN_STAY_MS = 2000
"""Minimum time [ms] that a message stays after the pointer has left it."""


class Toast(Themed, QFrame):
    """A message in one line, with buttons for its commands, if any, and a close button. It never takes the focus.

    Signals
    -------
    gone()
        Its time is over, or it was closed.
    """

    gone = Signal()

    def __init__(self, message: str, actions: Sequence[QAction]) -> None:
        super().__init__()
        self.setObjectName("toast")
        self.offered = tuple(actions)
        self.commands = [self._button(action) for action in actions]
        self.label = ElidedLabel(Qt.TextElideMode.ElideMiddle)
        self.close_button = flat_button("Close this message", self._go)
        row = lay_out(QHBoxLayout(self), self.label, margins=(6, 0, 1, 0), spacing=4, stretched=self.label)
        for button in (*self.commands, self.close_button):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            row.addWidget(button)
        self._over = QTimer(self, singleShot=True)
        self._over.timeout.connect(self._go)
        self.show_message(message)
        self._take_theme()

    def _button(self, action: QAction) -> QToolButton:
        button = QToolButton()
        button.setText(action.iconText().rstrip("…"))
        button.setToolTip(action.toolTip())
        button.clicked.connect(action.trigger)
        action.triggered.connect(self._go)  # also if it is triggered elsewhere
        return button

    def show_message(self, message: str) -> None:
        """Show a text."""
        self.message = message
        self.label.setText(message)
        self.setAccessibleName(message)
        QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.Alert))

    def stay(self, milliseconds: int) -> None:
        """Stay for a time; longer while the pointer is over it."""
        self._over.start(milliseconds)

    def enterEvent(self, event: QEnterEvent) -> None:
        """Stay while the pointer is over it."""
        super().enterEvent(event)
        self._over.setInterval(max(self._over.remainingTime(), _MIN_STAY_MS))
        self._over.stop()

    def leaveEvent(self, event: QEvent) -> None:
        """Restart the timer."""
        super().leaveEvent(event)
        self._over.start()

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        self.close_button.setIcon(theme.icon("ph.x", self.palette()))
        sheet = (
            f"#toast {{ background: {colours.background.name()}; border: 1px solid {colours.accent.name()}; "
            "border-radius: 4px; }"
        )
        if sheet != self.styleSheet():  # it changes the palette
            self.setStyleSheet(sheet)

    def _go(self) -> None:
        self._over.stop()
        self.gone.emit()


class Toasts(QObject):
    """The messages of a window, of which the newest is visible, at the left of its status bar."""

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.shown: list[Toast] = []
        """Those whose time is not over, the newest last."""

    @property
    def message(self) -> str:
        """Text of the visible message; "" for none."""
        return self.shown[-1].message if self.shown else ""

    def show_message(self, message: str, milliseconds: int, *actions: QAction) -> None:
        """Show a message for a time, optionally with commands; it replaces those with the same text or commands."""
        for former in list(self.shown):
            if former.message == message or (actions and former.offered == actions):
                self._drop(former)
        toast = Toast(message, actions)
        toast.gone.connect(lambda: self._drop(toast))
        self.shown.append(toast)
        self._window.statusBar().insertWidget(0, toast)
        for old in self.shown[:-MAX_TOASTS]:
            self._drop(old)
        toast.stay(milliseconds)
        self._show_newest()

    def change(self, message: str, milliseconds: int) -> None:
        """Change the text of the visible message, or show one if there is none."""
        if not self.shown:
            self.show_message(message, milliseconds)
            return
        self.shown[-1].show_message(message)
        self.shown[-1].stay(milliseconds)

    def clear(self) -> None:
        """Remove all messages."""
        for toast in list(self.shown):
            self._drop(toast)

    def _drop(self, toast: Toast) -> None:
        if toast in self.shown:
            self.shown.remove(toast)
            self._window.statusBar().removeWidget(toast)
            toast.deleteLater()
            self._show_newest()

    def _show_newest(self) -> None:
        for toast in self.shown:
            toast.setMaximumWidth(round(_SHARE * self._window.width()))
            toast.setVisible(toast is self.shown[-1])
