"""Pictures of a sweep, one for each point, with the best and the current one marked."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QIcon, QKeyEvent, QPainter, QPen, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
)

from ...base import theme

_GAP = 4
_RING = 2.5
_NUMBER, _BEST, _PRESENT = (Qt.ItemDataRole.UserRole + number for number in range(3))


def point_cell(
    text: str, hint: str, is_best: bool, is_present: bool, picture: QIcon, colour: QColor | None = None
) -> QTableWidgetItem:
    """Make a cell: a text, whether its point is one of the best or the current one, a picture, and the colour around
    it."""
    cell = QTableWidgetItem(picture, text)
    cell.setToolTip(hint)
    cell.setData(Qt.ItemDataRole.AccessibleTextRole, hint)
    cell.setData(_BEST, is_best)
    cell.setData(_PRESENT, is_present)
    if colour is not None:
        cell.setBackground(QBrush(colour))
        cell.setForeground(QBrush(QColor("black" if colour.lightness() > 120 else "white")))
    return cell


class PointCells(QTableWidget):
    """Cells of the points of a sweep, in as many columns as fit; or, of two parameters, in a column for each value of
    the first and a row for each value of the second, upwards. A click or Enter takes a point.

    Signals
    -------
    taken(int)
        The number of a point.
    """

    taken = Signal(int)

    def __init__(self, name: str) -> None:
        super().__init__()
        self._cells: Sequence[QTableWidgetItem] = ()
        self._rows = 0
        self.setAccessibleName(name)
        self.setItemDelegate(_CellDelegate(self))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setTabKeyNavigation(False)
        self.setShowGrid(False)
        self.setFrameShape(QTableWidget.Shape.NoFrame)
        self.viewport().setCursor(Qt.CursorShape.PointingHandCursor)
        self.cellClicked.connect(self._take)

    def arrange(self, heads: tuple[Sequence[str], Sequence[str]] | None, picture: QSize) -> None:
        """Set the values of both parameters, None for a single one, and the size of the pictures."""
        columns, rows = heads or ((), ())
        self._cells, self._rows = (), len(rows)
        self.clear()
        self.setRowCount(len(rows))
        self.setColumnCount(len(columns))
        self.setHorizontalHeaderLabels(columns)
        self.setVerticalHeaderLabels(rows[::-1])
        self.setIconSize(picture)
        size = picture + QSize(2 * _GAP, 2 * _GAP + 3 * self.fontMetrics().lineSpacing() + 6)
        for header, length in ((self.horizontalHeader(), size.width()), (self.verticalHeader(), size.height())):
            header.setVisible(heads is not None)
            header.setHighlightSections(False)
            header.setDefaultSectionSize(length)
            header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)

    def show_cells(self, cells: Sequence[QTableWidgetItem]) -> None:
        """Show a cell for each point, made by `point_cell`."""
        self._cells = cells
        self._fill()

    def place(self, number: int) -> tuple[int, int]:
        """Return row and column of a point."""
        if not self._rows:
            return divmod(number, max(self.columnCount(), 1))
        column, row = divmod(number, self._rows)
        return self._rows - 1 - row, column

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space):
            # not passed on, as that would press the default button of the window
            self._take(self.currentRow(), self.currentColumn())
        else:
            super().keyPressEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if not self._rows and self._fitting != self.columnCount():
            self._fill()

    def _take(self, row: int, column: int) -> None:
        if item := self.item(row, column):
            self.taken.emit(item.data(_NUMBER))

    @property
    def _fitting(self) -> int:
        """As many columns as there is room for beside the scroll bar."""
        room = self.width() - self.verticalScrollBar().sizeHint().width()
        return min(max(room // self.horizontalHeader().defaultSectionSize(), 1), len(self._cells))

    def _fill(self) -> None:
        for cell in self._cells:
            self.takeItem(self.row(cell), self.column(cell))
        if not self._rows:
            self.setColumnCount(self._fitting)
            self.setRowCount(-(-len(self._cells) // max(self._fitting, 1)))
        for number, cell in enumerate(self._cells):
            cell.setData(_NUMBER, number)
            self.setItem(*self.place(number), cell)


class _CellDelegate(QStyledItemDelegate):
    """Draws the text below the picture, and a ring around the best and the current cell."""

    def initStyleOption(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> None:
        super().initStyleOption(option, index)
        option.decorationPosition = QStyleOptionViewItem.Position.Top
        option.displayAlignment = Qt.AlignmentFlag.AlignCenter

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        super().paint(painter, option, index)
        colours, rect = theme.colours(option.palette), option.rect
        painter.setBrush(Qt.BrushStyle.NoBrush)
        over = index.data(Qt.ItemDataRole.ForegroundRole)
        if index.data(_BEST):
            painter.setPen(QPen(colours.good if over is None else over.color(), _RING))
            painter.drawRect(rect.adjusted(2, 2, -2, -2))
        if index.data(_PRESENT):
            painter.setPen(QPen(colours.text if over is None else over.color(), 1.5, Qt.PenStyle.DashLine))
            painter.drawRect(rect.adjusted(5, 5, -5, -5))
