"""The box that says what went wrong, or came out otherwise, with the technical text folded and a button that copies."""

from __future__ import annotations

import traceback

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMessageBox, QPushButton, QWidget

from gui.versions import versions_text
from ilf.errors import IlfError, in_words


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
