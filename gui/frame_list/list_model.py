"""The frames that are shown of the list, row by row."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QAbstractListModel, QModelIndex, QObject, QPersistentModelIndex, Qt
from PySide6.QtGui import QPixmap

from gui.frame_list.words import state_line, whole_text
from gui.state.entries import Entry
from gui.widgets.plain_text import as_it_is

Index = QModelIndex | QPersistentModelIndex

ENTRY, PRESENT = (Qt.ItemDataRole.UserRole + number for number in range(2))
_MOST_STEPS = 40
"""Stretches of rows that come or go one by one; beyond, the whole list is taken anew."""


class FrameListModel(QAbstractListModel):
    """Entries in the order in which they are shown.

    Parameters
    ----------
    picture_of : callable
        Gives an entry's thumbnail, None as long as there is none.
    """

    def __init__(self, picture_of: Callable[[Entry], QPixmap | None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._picture_of = picture_of
        self.entries: list[Entry] = []
        self._rows: dict[str, int] = {}
        self._present: Entry | None = None

    @property
    def present(self) -> Entry | None:
        """The frame that is shown."""
        return self._present

    def set_present(self, entry: Entry | None) -> None:
        """Mark another frame as the one that is shown."""
        former, self._present = self._present, entry
        for one in (former, entry):
            if one is not None:
                self.note_changed(one)

    def row_of(self, entry: Entry | None) -> int:
        """Where an entry stands; -1 if it is not shown."""
        return -1 if entry is None else self._rows.get(entry.id, -1)

    def index_of(self, entry: Entry | None) -> QModelIndex:
        """The same, as views want it."""
        row = self.row_of(entry)
        return self.index(row, 0) if row >= 0 else QModelIndex()

    def note_changed(self, entry: Entry) -> None:
        """There is something else to say of an entry."""
        index = self.index_of(entry)
        if index.isValid():
            self.dataChanged.emit(index, index)

    def set_entries(self, entries: Sequence[Entry]) -> None:
        """Show these. Rows that stay are the same ones as before, unless too much has changed."""
        wanted = list(entries)
        if wanted == self.entries:
            return
        ids = {entry.id for entry in wanted}
        going = _stretches([row for row, entry in enumerate(self.entries) if entry.id not in ids])
        coming = _stretches([row for row, entry in enumerate(wanted) if entry.id not in self._rows])
        staying = [entry for entry in self.entries if entry.id in ids]
        in_order = staying == [entry for entry in wanted if entry.id in self._rows]
        if not in_order or len(going) + len(coming) > _MOST_STEPS or not self.entries:
            self.beginResetModel()
            self._take(wanted)
            self.endResetModel()
            return
        for first, last in reversed(going):
            self.beginRemoveRows(QModelIndex(), first, last)
            self._take(self.entries[:first] + self.entries[last + 1 :])
            self.endRemoveRows()
        for first, last in coming:
            self.beginInsertRows(QModelIndex(), first, last)
            self._take(self.entries[:first] + wanted[first : last + 1] + self.entries[first:])
            self.endInsertRows()

    def _take(self, entries: list[Entry]) -> None:
        self.entries = entries
        self._rows = {entry.id: row for row, entry in enumerate(entries)}

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.entries)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if not index.isValid():
            return None
        entry = self.entries[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return entry.name
        if role == Qt.ItemDataRole.ToolTipRole:
            return as_it_is(whole_text(entry))
        if role == Qt.ItemDataRole.AccessibleTextRole:
            marks = [entry.note] * bool(entry.note) + ["unsaved"] * entry.unsaved
            return ", ".join((entry.name, state_line(entry), *marks))
        if role == Qt.ItemDataRole.DecorationRole:
            return self._picture_of(entry)
        if role == ENTRY:
            return entry
        return entry is self._present if role == PRESENT else None


def _stretches(rows: Sequence[int]) -> list[tuple[int, int]]:
    """Rows in rising order as first and last of those that follow each other."""
    found: list[tuple[int, int]] = []
    for row in rows:
        if found and found[-1][1] == row - 1:
            found[-1] = found[-1][0], row
        else:
            found.append((row, row))
    return found
