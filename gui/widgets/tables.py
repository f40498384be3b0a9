"""Common style of tables: a soft selection colour that keeps colours readable, and centred icons."""

from __future__ import annotations

from collections.abc import Collection
from functools import lru_cache

from PySide6.QtCore import QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QStyle, QStyledItemDelegate, QStyleOptionViewItem, QTableView, QWidget

from ..base.theme import blend

Index = QModelIndex | QPersistentModelIndex

ICON_SIZE = 16
_ROW_HEIGHT = 26
_FILLED = "ilf_filled"
"""Property of editors that already contain the cell's text."""


def set_up_table(view: QTableView, min_width: int = _ROW_HEIGHT) -> None:
    """Set up a table like all others: row selection, a context menu, smooth scrolling, no grid, and sortable columns of
    this minimum width."""
    view.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    view.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
    view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
    view.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    view.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    view.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
    view.setShowGrid(False)
    view.setWordWrap(False)
    view.setTabKeyNavigation(False)
    view.setFrameShape(QTableView.Shape.NoFrame)
    view.verticalHeader().hide()
    view.verticalHeader().setDefaultSectionSize(_ROW_HEIGHT)
    header = view.horizontalHeader()
    header.setMinimumSectionSize(min_width)
    header.setHighlightSections(False)
    header.setSortIndicatorClearable(True)
    header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
    view.setSortingEnabled(True)


class RowDelegate(QStyledItemDelegate):
    """Delegate that paints rows.

    Parameters
    ----------
    icon_columns : collection of int
        Columns with only a centred icon or colour.
    """

    def __init__(self, icon_columns: Collection[int], parent: QObject) -> None:
        super().__init__(parent)
        self._icon_columns = icon_columns

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """Set the text only once, so that changes of the cell do not overwrite the user's input."""
        if not editor.property(_FILLED):
            editor.setProperty(_FILLED, True)
            super().setEditorData(editor, index)

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        accent, base = option.palette.highlight().color(), option.palette.base().color()
        option.palette.setColor(QPalette.ColorRole.Highlight, _selection_colour(accent.rgb(), base.rgb()))
        option.palette.setColor(QPalette.ColorRole.HighlightedText, option.palette.text().color())
        option.state &= ~QStyle.StateFlag.State_HasFocus

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        if index.column() not in self._icon_columns:
            super().paint(painter, option, index)
            return
        full = QStyleOptionViewItem(option)
        self.initStyleOption(full, index)
        full.icon = QIcon()
        full.widget.style().drawControl(QStyle.ControlElement.CE_ItemViewItem, full, painter, full.widget)
        box = QRect(0, 0, ICON_SIZE, ICON_SIZE)
        box.moveCenter(option.rect.center())
        decoration = index.data(Qt.ItemDataRole.DecorationRole)
        if isinstance(decoration, QColor):
            painter.save()
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(decoration)
            painter.drawRoundedRect(box.adjusted(1, 1, -1, -1), 3, 3)
            painter.restore()
        elif decoration is not None:
            decoration.paint(painter, box)


@lru_cache(maxsize=8)
def _selection_colour(accent: int, base: int) -> QColor:
    """Return the background of selected rows; colours as numbers so that the cache works, used for every cell."""
    return blend(QColor(base), QColor(accent), 0.28)
