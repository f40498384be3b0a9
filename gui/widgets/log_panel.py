"""The log: messages with the time of day."""

from __future__ import annotations

from datetime import datetime

from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QHBoxLayout, QPlainTextEdit, QVBoxLayout, QWidget

from .basics import flat_button, lay_out

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
