"""A line under the views that says what is to be decided, with what can be done about it."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QLabel, QToolButton, QWidget


class ReviewStrip(QWidget):
    """Hidden until there is something to say.

    Parameters
    ----------
    actions : iterable of QAction
        What can be done, one button each.

    Signals
    -------
    closed()
        The user wants no more of it.
    """

    closed = Signal()

    def __init__(self, actions: Iterable[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setMinimumWidth(1)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 8, 2)
        layout.addWidget(self.label, 1)
        for action in actions:
            button = QToolButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            layout.addWidget(button)
        close = QToolButton()
        close.setText("Close")
        close.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        close.clicked.connect(self.closed)
        layout.addWidget(close)
        self.hide()

    def say(self, text: str) -> None:
        """Show a text; the whole of it as a tool tip, too, where there is no room for it."""
        self.label.setText(text)
        self.label.setToolTip(text)
        self.show()
