"""Marks in all views on what is to be looked at."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor, QPainterPath
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from ...views.linked_views import LinkedViews
from ...views.scene_items import HaloPath
from ...widgets.basics import PlainLabel

_COLOUR = QColor(255, 96, 208)
_WIDTH, _HALO, _HEIGHT = 1.5, 170, 5.5


class Marks:
    """One path in every view, in a colour that nothing else has."""

    def __init__(self, views: LinkedViews) -> None:
        self._items = []
        for cell in views.cells.values():
            item = HaloPath(_WIDTH, _COLOUR, _HALO, _HEIGHT)
            cell.view.add_overlay(item)
            self._items.append(item)

    @property
    def path(self) -> QPainterPath:
        """What is marked, in image coordinates."""
        return self._items[0].path

    def show(self, path: QPainterPath) -> None:
        """Mark a path in image coordinates."""
        for item in self._items:
            item.set_path(path)

    def clear(self) -> None:
        """Mark nothing."""
        for item in self._items:
            item.set_path(None)


# A line under the views that says what is to be decided, with what can be done about it.

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
