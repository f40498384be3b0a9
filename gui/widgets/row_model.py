"""Rows of a table that are given anew as a whole, and change only where they differ."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Generic, TypeVar

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex
from PySide6.QtWidgets import QWidget

Index = QModelIndex | QPersistentModelIndex
Row = TypeVar("Row")


class RowModel(QAbstractTableModel, Generic[Row]):
    """Base of models with one object per row; a proxy sorts them.

    Parameters
    ----------
    columns : int
        How many there are.
    """

    def __init__(self, columns: int, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: list[Row] = []
        self._columns = columns

    def key(self, row: Row) -> Hashable:
        """What a row is of: it stays the same row as long as this does."""
        raise NotImplementedError

    def look(self, row: Row, column: int) -> object:
        """All that decides how a cell looks and where it is sorted."""
        raise NotImplementedError

    def set_rows(self, rows: Sequence[Row]) -> None:
        """Show these rows; those that stay must be in the same order as before."""
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
        """Everything looks different."""
        if self.rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, self._columns - 1))

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else self._columns

    def _change(self, number: int, row: Row) -> None:
        """Announce just the columns that change: a name that is being typed must not be reset by the others."""
        before, self.rows[number] = self.rows[number], row
        if before == row:
            return
        for column in range(self._columns):
            # NaN is not equal to itself, its text is
            if repr(self.look(before, column)) != repr(self.look(row, column)):
                index = self.index(number, column)
                self.dataChanged.emit(index, index)
