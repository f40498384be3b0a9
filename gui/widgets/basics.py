"""Small parts that the dialogs share."""

from __future__ import annotations

import html
import os
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QSettings, Qt
from PySide6.QtGui import QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QGroupBox, QLabel, QVBoxLayout, QWidget

from ..base import theme

# Text of anyone's, shown letter by letter: Qt takes what looks like HTML for rich text unless it is told otherwise.


class PlainLabel(QLabel):
    """A label that shows names, paths and notes of files as they are. A QLabel itself is for rich text alone."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.setTextFormat(Qt.TextFormat.PlainText)


def as_it_is(text: str) -> str:
    """Text for message boxes and tool tips that shows just that: what Qt could take for rich text is made rich text
    that does."""
    if "<" not in text and "&lt;" not in text:
        return text
    return f'<p style="white-space: pre-wrap">{html.escape(text)}</p>'


class Message(PlainLabel):
    """Wrapped text in one of the theme's colours."""

    def __init__(self, lines: int = 1, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._tone = "muted"
        self.setWordWrap(True)
        self.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self.setMinimumHeight(lines * self.fontMetrics().lineSpacing())
        self._paint()

    def say(self, text: str, tone: str = "muted") -> None:
        """Show `text` in the colour of that name in `theme.Colours`."""
        # long paths have no spaces to wrap at
        self.setText(text.replace("/", "/\u200b"))
        self._tone = tone
        self._paint()

    def tone(self) -> str:
        """Name of the present colour."""
        return self._tone

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        # a new application style sheet, too, takes the label's own palette away
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.StyleChange):
            self._paint()

    def _paint(self) -> None:
        palette = QPalette()
        palette.setColor(QPalette.ColorRole.WindowText, getattr(theme.colours(palette), self._tone))
        self.setPalette(palette)


def group(title: str) -> tuple[QGroupBox, QVBoxLayout]:
    """A titled box and the column in it."""
    box = QGroupBox(title)
    column = QVBoxLayout(box)
    column.setContentsMargins(12, 10, 12, 12)
    column.setSpacing(8)
    return box, column


def last_folder(key: str) -> str:
    """The folder that a file dialog of this kind was last in, if it is still there; else the home folder."""
    folder = str(QSettings().value(key, ""))
    return folder if os.path.isdir(folder) else str(Path.home())


# What an empty list says instead of nothing.


def paint_hint(view: QAbstractItemView, text: str) -> None:
    """Paint `text` in the middle of a view's empty viewport; call it from the view's paintEvent."""
    painter = QPainter(view.viewport())
    painter.setPen(theme.colours(view.palette()).muted)
    area = view.viewport().rect().adjusted(16, 8, -16, -8)
    painter.drawText(area, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, text)
    painter.end()
