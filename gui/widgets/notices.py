"""The one way by which the window says something: in passing, in the log, and a box where it must not be missed."""

from __future__ import annotations

import traceback
from collections.abc import Iterable, Sequence
from datetime import datetime

from PySide6.QtCore import QEvent, QObject, QPoint, Qt, QTimer, Signal
from PySide6.QtGui import QAccessible, QAccessibleEvent, QAction, QEnterEvent, QGuiApplication, QHideEvent
from PySide6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QMessageBox,
    QPlainTextEdit,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.ending import note_fault
from ilf.errors import IlfError, in_words

from ..base import theme
from ..base.versions import versions_text
from .basics import PlainLabel

# The log: what happened, with the time of day.

MAXIMUM_LINES = 2000


class LogPanel(QWidget):
    """Messages in the order they came; they can be selected, copied and cleared."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.text = QPlainTextEdit()
        self.text.setReadOnly(True)
        self.text.setMaximumBlockCount(MAXIMUM_LINES)
        self.text.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.text.setPlaceholderText("Messages appear here.")
        self.text.setAccessibleName("Log")
        self.copy_button = _button("Copy", "Copy the whole log, or what is selected in it")
        self.copy_button.clicked.connect(self.copy)
        self.clear_button = _button("Clear", "Empty the log")
        self.clear_button.clicked.connect(self.text.clear)
        buttons = QVBoxLayout()
        buttons.setContentsMargins(4, 4, 4, 4)
        buttons.setSpacing(2)
        for button in (self.copy_button, self.clear_button):
            buttons.addWidget(button)
        buttons.addStretch(1)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(self.text, 1)
        row.addLayout(buttons)
        self.setFocusProxy(self.text)

    def add(self, message: str) -> None:
        """Append a message."""
        self.text.appendPlainText(f"{datetime.now():%H:%M:%S}  {message}")

    def copy(self) -> None:
        """Take what is selected to the clipboard, or all."""
        cursor = self.text.textCursor()
        chosen = cursor.selection().toPlainText() if cursor.hasSelection() else self.text.toPlainText()
        QGuiApplication.clipboard().setText(chosen)


def _button(text: str, hint: str) -> QToolButton:
    button = QToolButton()
    button.setText(text)
    button.setToolTip(hint)
    button.setAutoRaise(True)
    button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
    return button


# What the window says in passing: small notes over the lower right corner of the pictures, each for a while.

MOST = 3
"""How many notes there are at a time; the oldest makes way."""

_MARGIN = 10
_GAP = 6
_WIDTH = 400
_LEFT_ALONE_MS = 2000
"""For how long a note stays at least when the pointer has left it."""


class Toast(QFrame):
    """One note, with a button for its command, if it has one, and a cross. It never takes the focus.

    Signals
    -------
    gone()
        Its time is over, or it has been closed.
    """

    gone = Signal()

    def __init__(self, message: str, action: QAction | None, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("toast")
        self.action = action
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setWordWrap(True)
        self.close_button = QToolButton()
        self.close_button.setAccessibleName("Close this message")
        self.close_button.setToolTip("Close this message")
        self.close_button.clicked.connect(self._go)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(10, 6, 5, 6)
        self._grid.setHorizontalSpacing(6)
        self._grid.setColumnStretch(0, 1)
        self._grid.addWidget(self.label, 0, 0)
        self._grid.addWidget(self.close_button, 0, 1, Qt.AlignmentFlag.AlignTop)
        buttons = [self.close_button]
        if action is not None:
            self.command = QToolButton()
            self.command.setText(action.text().replace("&", "").rstrip("…"))
            self.command.setToolTip(action.toolTip())
            self.command.clicked.connect(action.trigger)
            action.triggered.connect(self._go)  # also if it is given in another way
            self._grid.addWidget(self.command, 1, 0, 1, 2, Qt.AlignmentFlag.AlignRight)
            buttons.append(self.command)
        for button in buttons:
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            button.setAutoRaise(button is self.close_button)
        self._over = QTimer(self, singleShot=True)
        self._over.timeout.connect(self._go)
        self.say(message)
        self._paint()

    def say(self, message: str) -> None:
        """Show this text."""
        self.message = message
        self.label.setText(message.replace("/", "/\u200b"))  # long paths have no spaces to wrap at
        self.setAccessibleName(message)
        QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.Alert))

    def stay(self, milliseconds: int) -> None:
        """Stay for so long; longer while the pointer is on it."""
        self._over.start(milliseconds)

    def fit(self, width: int) -> None:
        """Take the size that the text asks for, no wider than this."""
        self.ensurePolished()
        margins = self._grid.contentsMargins()
        taken = margins.left() + margins.right() + self._grid.horizontalSpacing() + self.close_button.sizeHint().width()
        line = self.label.fontMetrics().horizontalAdvance(self.label.text()) + 4
        self.label.setFixedWidth(max(min(line, width - taken), 1))
        self.setFixedWidth(self.label.width() + taken)
        self.resize(self.width(), self._grid.totalHeightForWidth(self.width()))

    def enterEvent(self, event: QEnterEvent) -> None:
        """Stay while it is being read."""
        super().enterEvent(event)
        self._over.setInterval(max(self._over.remainingTime(), _LEFT_ALONE_MS))
        self._over.stop()

    def leaveEvent(self, event: QEvent) -> None:
        """Go after a while."""
        super().leaveEvent(event)
        if self.isVisible():
            self._over.start()

    def hideEvent(self, event: QHideEvent) -> None:
        """A window that is closed leaves nothing waiting."""
        super().hideEvent(event)
        self._over.stop()

    def changeEvent(self, event: QEvent) -> None:
        """Take the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._paint()

    def _paint(self) -> None:
        colours = theme.colours(self.palette())
        self.close_button.setIcon(theme.icon("ph.x", self.palette()))
        sheet = (
            f"#toast {{ background: {colours.background.name()}; border: 1px solid {colours.accent.name()}; "
            "border-radius: 5px; }"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)

    def _go(self) -> None:
        self._over.stop()
        self.gone.emit()


class Toasts(QObject):
    """The notes that are to be seen, the newest below the others.

    Parameters
    ----------
    window : QWidget
        What they lie in.
    places : sequence of QWidget
        Over the lower right corner of the first that is visible; over that of the window if none is.
    """

    def __init__(self, window: QWidget, places: Sequence[QWidget] = ()) -> None:
        super().__init__(window)
        self._window = window
        self._places = places
        self.shown: list[Toast] = []
        for widget in (window, *places):
            widget.installEventFilter(self)

    @property
    def message(self) -> str:
        """What was said last and is still to be seen; "" for nothing."""
        return self.shown[-1].message if self.shown else ""

    def tell(self, message: str, milliseconds: int, action: QAction | None = None) -> None:
        """Say something for so long, and offer a command. What is said twice, or offers the same, stands
        there once, and anew."""
        for former in list(self.shown):
            if former.message == message or (action is not None and former.action is action):
                self._drop(former)
        toast = Toast(message, action, self._window)
        toast.gone.connect(lambda: self._drop(toast))
        self.shown.append(toast)
        for old in self.shown[:-MOST]:
            self._drop(old)
        toast.stay(milliseconds)
        self._place()

    def change(self, message: str, milliseconds: int) -> None:
        """Say something else in the place of what was said last."""
        if not self.shown:
            self.tell(message, milliseconds)
            return
        self.shown[-1].say(message)
        self.shown[-1].stay(milliseconds)
        self._place()

    def clear(self) -> None:
        """Take all away."""
        for toast in list(self.shown):
            self._drop(toast)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep to the corner."""
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.Move) and self.shown:
            QTimer.singleShot(0, self, self._place)  # when everything has its new place
        return False

    def _drop(self, toast: Toast) -> None:
        if toast in self.shown:
            self.shown.remove(toast)
            toast.hide()
            toast.deleteLater()
            self._place()

    def _place(self) -> None:
        place = next((widget for widget in self._places if widget.isVisible()), self._window)
        corner = place.mapTo(self._window, QPoint(place.width(), place.height())) - QPoint(_MARGIN, _MARGIN)
        bottom = corner.y()
        for toast in reversed(self.shown):
            toast.fit(min(_WIDTH, max(place.width() - 2 * _MARGIN, 1)))
            toast.move(corner.x() - toast.width(), bottom - toast.height())
            toast.show()
            toast.raise_()
            bottom -= toast.height() + _GAP


# The box that says what went wrong, or came out otherwise, with the technical text folded and a button that copies.


class ProblemBox(QMessageBox):
    """A title, what to tell of it, and details, which are folded at first; *Copy* takes all with the versions.

    Parameters
    ----------
    title, text : str
    details : str
        Technical; "" for none.
    parent : QWidget
        In front of which it opens, without holding up what goes on there.
    """

    def __init__(self, title: str, text: str, details: str, parent: QWidget | None) -> None:
        super().__init__(QMessageBox.Icon.Warning, title, text, QMessageBox.StandardButton.Ok, parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setTextInteractionFlags(
            Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
        )
        if details:
            self.setDetailedText(details)
        self.copy_button = QPushButton("&Copy")
        self.copy_button.setToolTip("Copy what is said here, with the details and all versions, as for a report")
        self.addButton(self.copy_button, QMessageBox.ButtonRole.ActionRole)
        self.copy_button.clicked.disconnect()  # it would close the box
        self.copy_button.clicked.connect(self._copy)
        self.setDefaultButton(QMessageBox.StandardButton.Ok)
        self.setEscapeButton(QMessageBox.StandardButton.Ok)

    def _copy(self) -> None:
        parts = (self.windowTitle(), self.text(), self.detailedText(), versions_text())
        QGuiApplication.clipboard().setText("\n\n".join(filter(None, parts)))


def warn(parent: QWidget, title: str, text: str, details: str = "") -> None:
    """Show a warning beside the work that goes on."""
    ProblemBox(title, text, details, parent).open()


def error_text(error: Exception) -> str:
    """What to tell of an error. What IlfError and the operating system say is meant for people."""
    return in_words(error) if _is_expected(error) else f"{type(error).__name__}: {error}"


def error_details(error: Exception) -> str:
    """Where an error comes from, for those who mend the program; "" of one that is expected to happen."""
    return "" if _is_expected(error) else "".join(traceback.format_exception(error))


def _is_expected(error: Exception) -> bool:
    return isinstance(error, (IlfError, OSError))


_TOLD_MS = 6000
_GLIMPSE_MS = 4000
_OFFERED_MS = 15_000


class Notes(QObject):
    """Says things to the user, and keeps in the log what may be wanted later.

    Signals
    -------
    reported(str)
        Something went wrong; a sentence that says what.
    """

    reported = Signal(str)

    def __init__(self, window: QWidget, toasts: Toasts, log: LogPanel) -> None:
        super().__init__(window)
        self._window = window
        self._toasts = toasts
        self._log = log
        self._glimpsed = ""

    def tell(self, message: str) -> None:
        """Something that needs no answer."""
        self._toasts.tell(message, _TOLD_MS)
        self._log.add(message)

    def offer(self, message: str, action: QAction) -> None:
        """Something that a command could be given for; it stays for a good while."""
        self._toasts.tell(message, _OFFERED_MS, action)

    def glimpse(self, message: str) -> None:
        """Something that is of no interest any more when it has been read, as it comes at every move of a slider; nor
        while anything else is said."""
        if self._toasts.message in ("", self._glimpsed):
            self._glimpsed = message
            self._toasts.change(message, _GLIMPSE_MS)

    def warn(self, what: str, notes: Iterable[str], details: str = "") -> None:
        """Something that was done, but not quite as asked for; nothing is shown if there are no notes."""
        texts = list(notes)
        for text in texts:
            self._log.add(f"{what}: {text}")
        if texts:
            warn(self._window, what, "\n\n".join(texts), details)

    def report(self, what: str, error: Exception) -> None:
        """Something that went wrong."""
        details = error_details(error)
        text = note_fault(error) if details else error_text(error)
        self.warn(what, [text], details)
        self.reported.emit(f"{what}: {text}")
