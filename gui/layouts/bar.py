"""The layouts at the end of the menu bar, each a click away."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from gui import theme

_MOST_WIDTH = 460
"""Layouts for which there is no room in so many pixels are in the menu alone."""


class _LayoutButton(QToolButton):
    """Turns to its layout as its action does, but never back."""

    def nextCheckState(self) -> None:
        if not self.isChecked():
            super().nextCheckState()


class LayoutBar(QWidget):
    """A button for each layout; that of the present one is marked, and a click on it changes nothing."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._row = QHBoxLayout(self)
        self._row.setContentsMargins(0, 0, 6, 0)
        self._row.setSpacing(2)
        self._buttons: dict[QAction, QToolButton] = {}
        self._paint()

    def set_actions(self, actions: Iterable[QAction]) -> None:
        """Have buttons for these."""
        wanted = list(actions)
        if list(self._buttons) != wanted:
            self._make(wanted)
        width = 0
        for action, button in self._buttons.items():
            width += button.sizeHint().width() + self._row.spacing()
            button.setVisible(width <= _MOST_WIDTH or action.isChecked())
        self.adjustSize()

    def _make(self, wanted: list[QAction]) -> None:
        for button in self._buttons.values():
            button.hide()
            button.deleteLater()
        self._buttons = {}
        for action in wanted:
            button = _LayoutButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self._row.addWidget(button)
            self._buttons[action] = button

    def changeEvent(self, event: QEvent) -> None:
        """Take the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._paint()

    def _paint(self) -> None:
        colours = theme.colours(self.palette())
        sheet = (
            "QToolButton { border: none; padding: 1px 7px; background: transparent; "
            f"color: {colours.muted.name()}; }}"
            f"QToolButton:hover {{ color: {colours.text.name()}; }}"
            f"QToolButton:checked {{ color: {colours.text.name()}; border-bottom: 2px solid {colours.accent.name()}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)
