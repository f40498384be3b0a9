"""What the window says in passing: over its lower left corner, until the user does something else."""

from __future__ import annotations

import html
from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, QPoint, Qt, QTimer
from PySide6.QtGui import QAction, QHideEvent, QKeyEvent
from PySide6.QtWidgets import QApplication, QLabel, QMainWindow, QWidget

from gui import theme

_MARGIN = 8
_MODIFIERS = frozenset({Qt.Key.Key_Shift, Qt.Key.Key_Control, Qt.Key.Key_Alt, Qt.Key.Key_Meta, Qt.Key.Key_AltGr})


class MessageStrip(QLabel):
    """One message, just above the status bar. The next click or key takes it away.

    A message may offer a command, which a click on it gives.

    Parameters
    ----------
    window : QMainWindow
    strips : sequence of QWidget
        What stands above the status bar and is not to be covered either.
    """

    def __init__(self, window: QMainWindow, strips: Sequence[QWidget] = ()) -> None:
        super().__init__(window)
        self._window = window
        self._strips = strips
        self._action: QAction | None = None
        self._listens = False
        self._over = QTimer(self, singleShot=True)
        self._over.timeout.connect(self.hide)
        self.setTextFormat(Qt.TextFormat.RichText)
        self.linkActivated.connect(self._give_command)
        for widget in (window, *strips):
            widget.installEventFilter(self)
        self.hide()

    @property
    def message(self) -> str:
        """What is said now; "" for nothing."""
        return self.property("message") if self.isVisible() else ""

    def tell(self, message: str, milliseconds: int, action: QAction | None = None) -> None:
        """Say something for so long at most, and offer a command."""
        self.setProperty("message", message)
        self._action = action
        colours = theme.colours(self.palette())
        link = (
            "" if action is None else f" &nbsp;<a style='color: {colours.accent.name()}' href='#'>{_name(action)}</a>"
        )
        self.setText(html.escape(message) + link)
        self.setStyleSheet(
            f"background: {colours.background.name()}; color: {colours.text.name()}; padding: 4px 8px; "
            f"border: 1px solid {colours.accent.name()}; border-radius: 4px;"
        )
        self.show()
        self._place()
        self.raise_()
        self._over.start(milliseconds)
        self._listens = False
        # what is going on now has given the message: the next thing takes it away
        QTimer.singleShot(0, self, self._listen)

    def hideEvent(self, event: QHideEvent) -> None:
        """Listen no more."""
        super().hideEvent(event)
        self._listens = False
        self._over.stop()
        application = QApplication.instance()
        if application is not None:
            application.removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep to the corner; go at the next click or key."""
        if event.type() == QEvent.Type.Resize and watched is self._window:
            self._place()
        elif event.type() in (QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.Move) and watched in self._strips:
            QTimer.singleShot(0, self, self._place)  # when it has its new place
        elif self._listens and _is_action(event) and isinstance(watched, QWidget) and watched is not self:
            self.hide()
        return False

    def _listen(self) -> None:
        application = QApplication.instance()
        self._listens = self.isVisible()
        if self._listens and application is not None:
            application.installEventFilter(self)

    def _place(self) -> None:
        self.setWordWrap(False)
        width = self._window.width() - 2 * _MARGIN
        if self.sizeHint().width() > width:
            self.setWordWrap(True)
            self.resize(width, self.heightForWidth(width))
        else:
            self.resize(self.sizeHint())
        below = [self._window.statusBar(), *(strip for strip in self._strips if strip.isVisible())]
        top = min(widget.mapTo(self._window, QPoint()).y() for widget in below)
        self.move(_MARGIN, top - self.height() - _MARGIN // 2)

    def _give_command(self, _: str) -> None:
        action = self._action
        self.hide()
        if action is not None:
            action.trigger()


def _is_action(event: QEvent) -> bool:
    if event.type() == QEvent.Type.MouseButtonPress:
        return True
    # what comes before every key, also those of commands
    before_key = event.type() == QEvent.Type.ShortcutOverride
    return before_key and isinstance(event, QKeyEvent) and event.key() not in _MODIFIERS


def _name(action: QAction) -> str:
    return html.escape(action.text().replace("&", "").rstrip("…"))
