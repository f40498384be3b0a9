"""Small widgets and functions that the dialogs share."""

from __future__ import annotations

import html
import os
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QSettings, Qt
from PySide6.QtGui import QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QGroupBox, QLabel, QVBoxLayout, QWidget

from ..base import theme

# Plain text from outside the program: Qt would treat text that looks like HTML as rich text.


class Themed:
    """Mixin, before the class of Qt, of a widget whose own colours and icons are made by `_take_theme`."""

    def _take_theme(self) -> None:
        """Apply the theme's colours."""
        raise NotImplementedError

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)  # type: ignore[misc]  # the class of Qt has it
        if event.type() == QEvent.Type.PaletteChange:
            self._take_theme()


class PlainLabel(QLabel):
    """A label for plain text, such as names, paths and notes. Use QLabel only for rich text."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.setTextFormat(Qt.TextFormat.PlainText)


def literal_text(text: str) -> str:
    """Return text for message boxes and tool tips that Qt shows literally: escaped if it looks like rich text."""
    if "<" not in text and "&lt;" not in text:
        return text
    return f'<p style="white-space: pre-wrap">{html.escape(text)}</p>'


class Message(PlainLabel):
    """A label with wrapped text in one of the theme's colours."""

    def __init__(self, lines: int = 1, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._tone = "muted"
        self.setWordWrap(True)
        self.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self.setMinimumHeight(lines * self.fontMetrics().lineSpacing())
        self._paint()

    def show_message(self, text: str, tone: str = "muted") -> None:
        """Show `text` in the colour named `tone` in `theme.Colours`."""
        # long paths have no spaces to wrap at
        self.setText(text.replace("/", "/\u200b"))
        self._tone = tone
        self._paint()

    def tone(self) -> str:
        """Return the name of the current colour."""
        return self._tone

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        # a new application style sheet also resets the label's own palette
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange):
            self._paint()

    def _paint(self) -> None:
        palette = QPalette()
        palette.setColor(QPalette.ColorRole.WindowText, getattr(theme.colours(palette), self._tone))
        self.setPalette(palette)


def group(title: str) -> tuple[QGroupBox, QVBoxLayout]:
    """Return a titled box and the column layout in it."""
    box = QGroupBox(title)
    column = QVBoxLayout(box)
    column.setContentsMargins(12, 10, 12, 12)
    column.setSpacing(8)
    return box, column


def last_folder(key: str) -> str:
    """Return the last folder of this kind of file dialog if it still exists; else the home folder."""
    folder = str(QSettings().value(key, ""))
    return folder if os.path.isdir(folder) else str(Path.home())


# Placeholder text of empty lists.


def paint_hint(view: QAbstractItemView, text: str) -> None:
    """Paint `text` in the middle of a view's empty viewport; call it from the view's paintEvent."""
    painter = QPainter(view.viewport())
    painter.setPen(theme.colours(view.palette()).muted)
    area = view.viewport().rect().adjusted(16, 8, -16, -8)
    painter.drawText(area, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, text)
    painter.end()
