"""Table models that update only changed rows, and the common style of tables."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from functools import lru_cache
from typing import Generic, TypeVar

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QObject, QPersistentModelIndex, QRect, QSize, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette
from PySide6.QtWidgets import QAbstractItemView, QStyle, QStyledItemDelegate, QStyleOptionViewItem, QTableView, QWidget

Index = QModelIndex | QPersistentModelIndex
Row = TypeVar("Row")


class RowModel(QAbstractTableModel, Generic[Row]):
    """Base of table models with one object per row; a proxy sorts them.

    Parameters
    ----------
    columns : int
        Number of columns.
    """

    def __init__(self, columns: int, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: list[Row] = []
        self._columns = columns

    def key(self, row: Row) -> Hashable:
        """Return the identity of a row: rows with equal keys are the same row."""
        raise NotImplementedError

    def look(self, row: Row, column: int) -> object:
        """Return everything that determines a cell's appearance and sort position."""
        raise NotImplementedError

    def set_rows(self, rows: Sequence[Row]) -> None:
        """Show these rows; remaining rows must be in the same order as before."""
        wanted = {self.key(row) for row in rows}
        for number in reversed(range(len(self.rows))):
            if self.key(self.rows[number]) not in wanted:
                self.beginRemoveRows(QModelIndex(), number, number)
                del self.rows[number]
                self.endRemoveRows()
        for number, row in enumerate(rows):
            if number == len(self.rows) or self.key(self.rows[number]) != self.key(row):
                self.beginInsertRows(QModelIndex(), number, number)
                self.rows.insert(number, row)
                self.endInsertRows()
            else:
                self._change(number, row)

    def announce_all(self) -> None:
        """Announce a change of all cells."""
        if self.rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, self._columns - 1))

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else self._columns

    def _change(self, number: int, row: Row) -> None:
        """Announce only the columns that change: other changes must not reset a name that is being edited."""
        before, self.rows[number] = self.rows[number], row
        if before == row:
            return
        for column in range(self._columns):
            # by repr: NaN is not equal to itself
            if repr(self.look(before, column)) != repr(self.look(row, column)):
                index = self.index(number, column)
                self.dataChanged.emit(index, index)


# Appearance of rows: a soft selection colour that keeps colours readable, and centred icons.

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
    elided_within : collection of int
        Columns where long texts are elided in the middle.
    """

    def __init__(
        self, icon_columns: Collection[int], parent: QObject | None = None, elided_within: Collection[int] = ()
    ) -> None:
        super().__init__(parent)
        self._icon_columns = icon_columns
        self._elided_within = elided_within

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
def _selection_colour(accent: int, base: int) -> QColor:
    """Return the background of selected rows; colours as numbers so that the cache works, used for every cell."""
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
