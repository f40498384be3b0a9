"""Messages of the window: temporary notes, the log, and message boxes."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Sequence
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

from ilf._runtime.termination import log_error
from ilf.errors import IlfError, to_text, without_credentials

from ..base import theme
from ..base.versions import versions_text
from .basics import PlainLabel, Themed

# The log: messages with the time of day.

MAXIMUM_LINES = 2000


class LogPanel(QWidget):
    """The log: messages in order of time, which can be selected, copied and cleared."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.text = QPlainTextEdit()
        self.text.setReadOnly(True)
        self.text.setMaximumBlockCount(MAXIMUM_LINES)
        self.text.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.text.setPlaceholderText("Messages appear here.")
        self.text.setAccessibleName("Log")
        self.copy_button = _button("Copy", "Copy the log, or the selected part of it")
        self.copy_button.clicked.connect(self.copy)
        self.clear_button = _button("Clear", "Clear the log")
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
        """Copy the selected text, or all, to the clipboard."""
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


# Temporary notes over the lower right corner of the images.

MAX_NOTES = 3
"""Maximum number of notes at a time; a new one replaces the oldest."""

_MARGIN = 10
_GAP = 6
_WIDTH = 400
_MIN_STAY_MS = 2000
"""Minimum time [ms] that a note stays after the pointer has left it."""


class Toast(Themed, QFrame):
    """A note with buttons for its commands, if any, and a close button. It never takes the focus.

    Signals
    -------
    gone()
        Its time is over, or it was closed.
    """

    gone = Signal()

    def __init__(self, message: str, actions: Sequence[QAction], parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("toast")
        self.offered = tuple(actions)
        self.commands = [self._button(action) for action in actions]
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
        if self.commands:
            row = QHBoxLayout()
            row.addStretch(1)
            for command in self.commands:
                row.addWidget(command)
            self._grid.addLayout(row, 1, 0, 1, 2)
        for button in (self.close_button, *self.commands):
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            button.setAutoRaise(button is self.close_button)
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
        self.label.setText(message.replace("/", "/\u200b"))  # long paths have no spaces to wrap at
        self.setAccessibleName(message)
        QAccessible.updateAccessibility(QAccessibleEvent(self, QAccessible.Event.Alert))

    def stay(self, milliseconds: int) -> None:
        """Stay for a time; longer while the pointer is over it."""
        self._over.start(milliseconds)

    def fit(self, width: int) -> None:
        """Resize to the text, with at most this width."""
        self.ensurePolished()
        margins = self._grid.contentsMargins()
        taken = margins.left() + margins.right() + self._grid.horizontalSpacing() + self.close_button.sizeHint().width()
        line = self.label.fontMetrics().horizontalAdvance(self.label.text()) + 4
        self.label.setFixedWidth(max(min(line, width - taken), 1))
        self.setFixedWidth(self.label.width() + taken)
        self.resize(self.width(), self._grid.totalHeightForWidth(self.width()))

    def enterEvent(self, event: QEnterEvent) -> None:
        """Stay while the pointer is over it."""
        super().enterEvent(event)
        self._over.setInterval(max(self._over.remainingTime(), _MIN_STAY_MS))
        self._over.stop()

    def leaveEvent(self, event: QEvent) -> None:
        """Restart the timer."""
        super().leaveEvent(event)
        if self.isVisible():
            self._over.start()

    def hideEvent(self, event: QHideEvent) -> None:
        """Stop the timer."""
        super().hideEvent(event)
        self._over.stop()

    def _take_theme(self) -> None:
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
    """The visible notes, the newest at the bottom.

    Parameters
    ----------
    window : QWidget
        Their parent.
    places : sequence of QWidget
        They are over the lower right corner of the first visible one, or of the window if none is.
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
        """Text of the newest visible note; "" for none."""
        return self.shown[-1].message if self.shown else ""

    def show_message(self, message: str, milliseconds: int, *actions: QAction) -> None:
        """Show a note for a time, optionally with commands; it replaces notes with the same text or commands."""
        for former in list(self.shown):
            if former.message == message or (actions and former.offered == actions):
                self._drop(former)
        toast = Toast(message, actions, self._window)
        toast.gone.connect(lambda: self._drop(toast))
        self.shown.append(toast)
        for old in self.shown[:-MAX_NOTES]:
            self._drop(old)
        toast.stay(milliseconds)
        self._place()

    def change(self, message: str, milliseconds: int) -> None:
        """Change the text of the newest note, or show a note if there is none."""
        if not self.shown:
            self.show_message(message, milliseconds)
            return
        self.shown[-1].show_message(message)
        self.shown[-1].stay(milliseconds)
        self._place()

    def give_way(self) -> None:
        """Remove the notes without a command, which would cover what is worked on."""
        for toast in list(self.shown):
            if not toast.commands:
                self._drop(toast)

    def clear(self) -> None:
        """Remove all notes."""
        for toast in list(self.shown):
            self._drop(toast)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep the notes in the corner."""
        if event.type() in (QEvent.Type.Resize, QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.Move) and self.shown:
            QTimer.singleShot(0, self, self._place)  # after the layout is updated
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


# Message box for errors and warnings, with collapsed technical details and a copy button.


class ProblemBox(QMessageBox):
    """A message box with collapsed details; *Copy* copies all of it with the versions.

    Parameters
    ----------
    title, text : str
    details : str
        Technical details; "" for none.
    parent : QWidget
        The widget in front of which it opens, without blocking it.
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
        self.copy_button.setToolTip("Copy this message, its details and all versions, for a bug report")
        self.addButton(self.copy_button, QMessageBox.ButtonRole.ActionRole)
        self.copy_button.clicked.disconnect()  # it would close the box
        self.copy_button.clicked.connect(self._copy)
        self.setDefaultButton(QMessageBox.StandardButton.Ok)
        self.setEscapeButton(QMessageBox.StandardButton.Ok)

    def _copy(self) -> None:
        parts = (self.windowTitle(), self.text(), self.detailedText(), versions_text())
        QGuiApplication.clipboard().setText("\n\n".join(filter(None, parts)))


def question(
    parent: QWidget, title: str, text: str, more: str = "", icon: QMessageBox.Icon = QMessageBox.Icon.Warning
) -> QMessageBox:
    """Make a question in plain text, which is deleted when it is closed; the caller adds the buttons and opens it."""
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setIcon(icon)
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setWindowTitle(title)
    box.setText(text)
    box.setInformativeText(more)
    return box


Answer = tuple[str, QMessageBox.ButtonRole, Callable[[], object]]
"""A button of a question, its role, and what it does."""

DESTROY, ACCEPT = QMessageBox.ButtonRole.DestructiveRole, QMessageBox.ButtonRole.AcceptRole


def ask(
    parent: QWidget,
    title: str,
    text: str,
    more: str,
    answers: Sequence[Answer],
    *,
    default: int = -1,
    otherwise: Callable[[], object] = lambda: None,
    icon: QMessageBox.Icon = QMessageBox.Icon.Warning,
) -> None:
    """Ask a question without blocking.

    Parameters
    ----------
    title, text, more : str
        Title of the box, the question, and a sentence below it.
    answers : sequence of Answer
        *Cancel* is added to them.
    default : int
        Position of the default answer; -1 for *Cancel*.
    otherwise : callable
        Called if the user cancels.
    """
    box = question(parent, title, text, more, icon)
    buttons = [box.addButton(name, role) for name, role, _ in answers]
    buttons.append(box.addButton(QMessageBox.StandardButton.Cancel))
    box.setDefaultButton(buttons[default])

    def answer() -> None:
        clicked = box.clickedButton()
        done = next((do for button, (_, _, do) in zip(buttons, answers, strict=False) if button is clicked), otherwise)
        done()

    box.finished.connect(lambda _: answer())
    box.open()


def ask_yes_no(
    parent: QWidget,
    title: str,
    text: str,
    more: str,
    yes: Callable[[], object],
    no: Callable[[], object] = lambda: None,
) -> None:
    """Ask whether to do something without blocking; *No* is the default answer."""
    box = question(parent, title, text, more)
    box.setStandardButtons(QMessageBox.StandardButton.Yes | QMessageBox.StandardButton.No)
    box.setDefaultButton(QMessageBox.StandardButton.No)
    box.finished.connect(lambda answer: yes() if answer == QMessageBox.StandardButton.Yes else no())
    box.open()


def warn(parent: QWidget, title: str, text: str, details: str = "") -> None:
    """Show a warning without blocking."""
    ProblemBox(title, text, details, parent).open()


def error_text(error: Exception) -> str:
    """Return the text of an error for the user; with its type if it is unexpected."""
    return to_text(error) if _is_expected(error) else without_credentials(f"{type(error).__name__}: {error}")


def error_details(error: Exception) -> str:
    """Return the traceback of an unexpected error; "" for an expected one (IlfError, OSError)."""
    return "" if _is_expected(error) else without_credentials("".join(traceback.format_exception(error)))


def _is_expected(error: Exception) -> bool:
    return isinstance(error, (IlfError, OSError))


_MESSAGE_MS = 6000
_BRIEF_MS = 4000
_COMMAND_MS = 15_000


class Notes(QObject):
    """Shows messages to the user and adds them to the log.

    Signals
    -------
    reported(str)
        The text of an error.
    """

    reported = Signal(str)

    def __init__(self, window: QWidget, toasts: Toasts, log: LogPanel) -> None:
        super().__init__(window)
        self._window = window
        self._toasts = toasts
        self._log = log
        self._brief = ""

    def show_message(self, message: str) -> None:
        """Show a message and add it to the log."""
        self._toasts.show_message(message, _MESSAGE_MS)
        self._log.add(message)

    def offer(self, message: str, *actions: QAction) -> None:
        """Show a message with commands, for a longer time."""
        self._toasts.show_message(message, _COMMAND_MS, *actions)

    def show_briefly(self, message: str) -> None:
        """Show a short-lived message that is not logged, as at every move of a slider; not over other messages."""
        if self._toasts.message in ("", self._brief):
            self._brief = message
            self._toasts.change(message, _BRIEF_MS)

    def warn(self, what: str, notes: Iterable[str], details: str = "") -> None:
        """Show notes on work that was done with restrictions, and log them; nothing if there are no notes."""
        texts = list(notes)
        for text in texts:
            self._log.add(f"{what}: {text}")
        if texts:
            warn(self._window, what, "\n\n".join(texts), details)

    def report(self, what: str, error: Exception) -> None:
        """Show and log an error."""
        details = error_details(error)
        text = log_error(error) if details else error_text(error)
        self.warn(what, [text], details)
        self.reported.emit(f"{what}: {text}")
