"""A line under the views that says what is to be decided, with what can be done about it."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from gui.widgets.plain_text import PlainLabel

_LEAST_TEXT = 120


class ReviewStrip(QWidget):
    """Hidden until there is something to say.

    Parameters
    ----------
    icons, named : iterable of QAction
        What can be done: buttons with their icons alone, and beside them some with their names, too.
    """

    def __init__(self, icons: Iterable[QAction], named: Iterable[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setWordWrap(True)
        self.label.setMinimumWidth(_LEAST_TEXT)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 8, 2)
        layout.addWidget(self.label, 1)
        style = Qt.ToolButtonStyle
        for actions, shown in ((named, style.ToolButtonTextBesideIcon), (icons, style.ToolButtonIconOnly)):
            for action in actions:
                button = QToolButton()
                button.setDefaultAction(action)
                button.setToolButtonStyle(shown)
                # keys go on to the views
                button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
                layout.addWidget(button)
        self.hide()

    def say(self, text: str) -> None:
        """Show a text."""
        self.label.setText(text)
        self.show()
