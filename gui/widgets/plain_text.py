"""Text of anyone's, shown letter by letter: Qt takes what looks like HTML for rich text unless it is told otherwise."""

from __future__ import annotations

import html
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel


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
