"""The log: what happened, with the time of day."""

from __future__ import annotations

from datetime import datetime

from PySide6.QtWidgets import QPlainTextEdit, QWidget

MAXIMUM_LINES = 2000


class LogPanel(QPlainTextEdit):
    """Messages in the order they came; read-only, can be selected and copied."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setReadOnly(True)
        self.setMaximumBlockCount(MAXIMUM_LINES)
        self.setFrameShape(QPlainTextEdit.Shape.NoFrame)
        self.setPlaceholderText("Messages appear here.")

    def add(self, message: str) -> None:
        """Append a message."""
        self.appendPlainText(f"{datetime.now():%H:%M:%S}  {message}")
