"""Marks in all views on what is to be looked at."""

from __future__ import annotations

from PySide6.QtGui import QColor, QPainterPath

from gui.views.items import HaloPath
from gui.views.linked_views import LinkedViews

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
