"""How rows of tables look: a soft selection that leaves colours readable, and icons in the middle of their columns."""

from __future__ import annotations

from collections.abc import Collection
from functools import lru_cache

from PySide6.QtCore import QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette
from PySide6.QtWidgets import (
    QAbstractItemView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

ICON_SIZE = 16
_ROW_HEIGHT = 26
_FILLED = "ilf_filled"
"""Property of editors that have the cell's text."""

Index = QModelIndex | QPersistentModelIndex


def lay_out(view: QTableView, least_width: int = _ROW_HEIGHT) -> None:
    """Give a table what all of ours have: whole rows to choose, a menu, smooth scrolling, no lines between rows, and
    columns of this least width to sort by, or by none."""
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
    header.setMinimumSectionSize(least_width)
    header.setHighlightSections(False)
    header.setSortIndicatorClearable(True)
    header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
    view.setSortingEnabled(True)


class SoftRows(QStyledItemDelegate):
    """Paints rows.

    Parameters
    ----------
    icon_columns : collection of int
        Columns that show nothing but an icon or a colour, in the middle.
    elided_within : collection of int
        Columns where the ends of a text that is too long are shown, and not its beginning alone.
    """

    def __init__(
        self, icon_columns: Collection[int], parent: QObject | None = None, elided_within: Collection[int] = ()
    ) -> None:
        super().__init__(parent)
        self._icon_columns = icon_columns
        self._elided_within = elided_within

    def setEditorData(self, editor: QWidget, index: Index) -> None:
        """What is being typed stays, whatever becomes of the cell meanwhile."""
        if not editor.property(_FILLED):
            editor.setProperty(_FILLED, True)
            super().setEditorData(editor, index)

    def initStyleOption(self, option: QStyleOptionViewItem, index: Index) -> None:
        super().initStyleOption(option, index)
        accent, base = option.palette.highlight().color(), option.palette.base().color()
        option.palette.setColor(QPalette.ColorRole.Highlight, _soft(accent.rgb(), base.rgb()))
        option.palette.setColor(QPalette.ColorRole.HighlightedText, option.palette.text().color())
        option.state &= ~QStyle.StateFlag.State_HasFocus
        if index.column() in self._elided_within:
            option.textElideMode = Qt.TextElideMode.ElideMiddle

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
def _soft(accent: int, base: int) -> QColor:
    """What marks selected rows, of the palette's colours as numbers: asked for once for every cell."""
    return _blend(QColor(accent), QColor(base), 0.28)


def _blend(colour: QColor, other: QColor, share: float) -> QColor:
    red, green, blue = (
        share * a + (1 - share) * b
        for a, b in (
            (colour.redF(), other.redF()),
            (colour.greenF(), other.greenF()),
            (colour.blueF(), other.blueF()),
        )
    )
    return QColor.fromRgbF(red, green, blue)
