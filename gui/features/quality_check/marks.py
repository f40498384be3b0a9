"""Marks of places to check and previews of their remedies in all views, and the line with the commands on them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor, QPainterPath
from PySide6.QtWidgets import QHBoxLayout, QToolButton, QWidget

from ilf.evaluation.quality.remedies import Remedy

from ...views.interaction import Preview, PreviewItem
from ...views.linked_views import LinkedViews
from ...views.pixel_items import boundary_path
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


class RemedyPreviews:
    """Dashed outline of what a remedy changes, in every view, as the previews of the tools."""

    def __init__(self, views: LinkedViews) -> None:
        self._items = []
        for cell in views.cells.values():
            item = PreviewItem(_HEIGHT)
            cell.view.add_overlay(item)
            self._items.append(item)

    def show(self, remedy: Remedy | None) -> None:
        """Show the pixels that a remedy changes; None for nothing."""
        preview = _preview(remedy)
        for item in self._items:
            item.set_preview(preview)


def _preview(remedy: Remedy | None) -> Preview | None:
    if remedy is None:
        return None
    if remedy.patch is not None:
        rows, columns = remedy.patch.box
        path = boundary_path(remedy.patch.before != remedy.patch.after, columns.start, rows.start)
    elif remedy.invalid is not None:
        path = boundary_path(remedy.invalid)
    elif remedy.by_hand is not None:
        path = boundary_path(np.isfinite(remedy.by_hand))
    else:
        return None
    return Preview(path, dashed=True)


# Line under the views with a message and commands.

_MIN_TEXT_WIDTH = 120


class ReviewStrip(QWidget):
    """Line with a message and buttons; hidden without a message.

    Parameters
    ----------
    named : iterable of QAction
        Commands: buttons with icons and names.
    """

    def __init__(self, named: Iterable[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setWordWrap(True)
        self.label.setMinimumWidth(_MIN_TEXT_WIDTH)
        self.row = QHBoxLayout(self)
        self.row.setContentsMargins(8, 2, 8, 2)
        self.row.addWidget(self.label, 1)
        for action in named:
            self.row.addWidget(_button(action, Qt.ToolButtonStyle.ToolButtonTextBesideIcon))
        self.hide()

    def show_message(self, text: str) -> None:
        """Show a message."""
        self.label.setText(text)
        self.show()


class CheckStrip(ReviewStrip):
    """Line with the position among the places between arrows, a message, the remedy, and further buttons.

    Parameters
    ----------
    previous, following, ignore, apply, close : QAction
        The commands.
    """

    def __init__(self, previous: QAction, following: QAction, ignore: QAction, apply: QAction, close: QAction) -> None:
        super().__init__([ignore])
        icon_only = Qt.ToolButtonStyle.ToolButtonIconOnly
        self.position = PlainLabel()
        arrows = [_button(action, icon_only) for action in (previous, following)]
        for arrow, way in zip(arrows, (Qt.ArrowType.LeftArrow, Qt.ArrowType.RightArrow), strict=True):
            arrow.setArrowType(way)
        for place, widget in enumerate((arrows[0], self.position, arrows[1])):
            self.row.insertWidget(place, widget)
        self.remedy = _button(apply, Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.remedy.setAccessibleName("Remedy")
        self._remedy_text = apply.iconText()
        apply.changed.connect(lambda: self.remedy.setText(self._remedy_text))  # it would get the command's text
        self.row.insertWidget(self.row.count() - 1, self.remedy)
        self.row.addWidget(_button(close, icon_only))

    def show_places(self, text: str, position: str = "") -> None:
        """Show a message, and the position of the current place as "3 of 17"; without one there is no remedy."""
        self.position.setText(position)
        for widget in (self.position, self.remedy):
            widget.setVisible(bool(position))
        self.show_message(text)

    def show_remedy(self, text: str) -> None:
        """Show what the remedy does, or why there is none."""
        self._remedy_text = text
        self.remedy.setText(text)


def _button(action: QAction, style: Qt.ToolButtonStyle) -> QToolButton:
    button = QToolButton()
    button.setDefaultAction(action)
    button.setToolButtonStyle(style)
    # keeps the keyboard focus in the views
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    return button
