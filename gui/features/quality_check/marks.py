"""Marks of places to check in all views, and the line with the commands on them."""

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


class PlaceMarks:
    """The same path in every view, in a colour used for nothing else."""

    def __init__(self, views: LinkedViews) -> None:
        self._items = []
        for cell in views.cells.values():
            item = HaloPath(_WIDTH, _COLOUR, _HALO, _HEIGHT)
            cell.view.add_overlay(item)
            self._items.append(item)

    @property
    def path(self) -> QPainterPath:
        """The marked path, in image coordinates."""
        return self._items[0].path

    def show(self, path: QPainterPath) -> None:
        """Mark a path in image coordinates."""
        for item in self._items:
            item.set_path(path)

    def clear(self) -> None:
        """Remove the mark."""
        for item in self._items:
            item.set_path(None)


# Line under the views with a message and commands.

_MIN_TEXT_WIDTH = 120


class ReviewStrip(QWidget):
    """Line with a message and buttons; hidden without a message.

    Parameters
    ----------
    icons, named : iterable of QAction
        Commands: buttons with icons only, and buttons with icons and names.
    """

    def __init__(self, icons: Iterable[QAction], named: Iterable[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setWordWrap(True)
        self.label.setMinimumWidth(_MIN_TEXT_WIDTH)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 8, 2)
        layout.addWidget(self.label, 1)
        style = Qt.ToolButtonStyle
        for actions, shown in ((named, style.ToolButtonTextBesideIcon), (icons, style.ToolButtonIconOnly)):
            for action in actions:
                button = QToolButton()
                button.setDefaultAction(action)
                button.setToolButtonStyle(shown)
                # keeps the keyboard focus in the views
                button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
                layout.addWidget(button)
        self.hide()

    def show_message(self, text: str) -> None:
        """Show a message."""
        self.label.setText(text)
        self.show()
