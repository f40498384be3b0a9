"""Message boxes, the log, and the texts of errors."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from datetime import datetime

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QMessageBox, QPlainTextEdit, QPushButton, QVBoxLayout, QWidget

from ilf.errors import IlfError, to_text, without_credentials

from ..base import theme
from ..base.versions import versions_text
from .basics import flat_button, lay_out, without_flags


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
        super().__init__(QMessageBox.Icon.NoIcon, title, text, QMessageBox.StandardButton.Ok, parent)
        show_icon(self, QMessageBox.Icon.Warning)
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


_ICONS = {
    QMessageBox.Icon.Warning: ("ph.warning", "warning"),
    QMessageBox.Icon.Question: ("ph.question", "accent"),
    QMessageBox.Icon.Information: ("ph.info", "accent"),
}
_ICON_SIZE = 40


def show_icon(box: QMessageBox, icon: QMessageBox.Icon) -> None:
    """Give a message box its icon, of the same family as all others."""
    name, tone = _ICONS[icon]
    box.setIconPixmap(theme.icon(name, tone).pixmap(_ICON_SIZE))


DESTROY, ACCEPT = QMessageBox.ButtonRole.DestructiveRole, QMessageBox.ButtonRole.AcceptRole


def ask(
    parent: QWidget,
    title: str,
    text: str,
    more: str,
    answers: Sequence[tuple[str, QMessageBox.ButtonRole]],
    take: Callable[[str], object],
    *,
    default: int = -1,
    icon: QMessageBox.Icon = QMessageBox.Icon.Warning,
    cancel: str = "Cancel",
) -> None:
    """Ask a question in plain text without blocking, and call `take` with the text of the answer, "" for *Cancel*.

    Parameters
    ----------
    title, text, more : str
        Title of the box, the question, and a sentence below it.
    answers : sequence of (str, ButtonRole)
        *Cancel*, or another text, is added to them.
    take : callable
    default : int
        Position of the default answer; -1 for *Cancel*.
    """
    box = QMessageBox(parent)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    show_icon(box, icon)
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setWindowTitle(title)
    box.setText(text)
    box.setInformativeText(more)
    buttons = [box.addButton(name, role) for name, role in answers]
    buttons.append(box.addButton(QMessageBox.StandardButton.Cancel))
    buttons[-1].setText(cancel)
    box.setDefaultButton(buttons[default])

    def answer() -> None:
        clicked = box.clickedButton()
        take(next((name for button, (name, _) in zip(buttons, answers, strict=False) if button is clicked), ""))

    box.finished.connect(lambda _: answer())
    box.open()


def error_text(error: Exception) -> str:
    """Return the text of an error for the user, without options of the command line; with its type if it is
    unexpected."""
    if _is_expected(error):
        return without_flags(to_text(error))
    return without_credentials(f"{type(error).__name__}: {error}")


def error_details(error: Exception) -> str:
    """Return the traceback of an unexpected error; "" for an expected one (IlfError, OSError)."""
    return "" if _is_expected(error) else without_credentials("".join(traceback.format_exception(error)))


def _is_expected(error: Exception) -> bool:
    return isinstance(error, (IlfError, OSError))


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
        self.copy_button = flat_button("Copy the log, or the selected part of it", self.copy, "Copy", "Copy")
        self.clear_button = flat_button("Clear the log", self.text.clear, "Clear", "Clear")
        buttons = lay_out(QVBoxLayout(), self.copy_button, self.clear_button, None, margins=(4, 4, 4, 4), spacing=2)
        lay_out(QHBoxLayout(self), self.text, buttons, spacing=0, stretched=self.text)
        self.setFocusProxy(self.text)

    def add(self, message: str) -> None:
        """Append a message."""
        self.text.appendPlainText(f"{datetime.now():%H:%M:%S}  {message}")

    def copy(self) -> None:
        """Copy the selected text, or all, to the clipboard."""
        cursor = self.text.textCursor()
        chosen = cursor.selection().toPlainText() if cursor.hasSelection() else self.text.toPlainText()
        QGuiApplication.clipboard().setText(chosen)
