"""Model of the frame list: texts, rows, filter and order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import Any

from PySide6.QtCore import QAbstractListModel, QModelIndex, QObject, Qt, Signal
from PySide6.QtGui import QPixmap

from ilf._runtime.formatting import counted, natural
from ilf.project.project import FrameSummary, Stage

from ...state.workspace import Entry
from ...widgets.basics import literal_text
from ...widgets.row_table import Index

# Texts of a frame in the list.


def state_line(entry: Entry) -> str:
    """Describe the state of the work on a frame in one line."""
    summary = entry.summary
    parts = [summary.stage.capitalize()]
    if summary.completed:
        parts.append(f"{summary.completed} of {counted(summary.blocks, 'block')}")
    elif summary.blocks:
        parts.append(counted(summary.blocks, "block"))
    parts += [f"{summary.to_check} to check"] * bool(summary.to_check) + ["done"] * summary.done
    return ", ".join(parts)


def size_line(summary: FrameSummary) -> str:
    """Describe the size of a frame, its missing share, and whether it has its own parameters; "" before it has been
    read."""
    size = "" if summary.shape is None else f"{summary.shape[1]} x {summary.shape[0]}"
    missing = "" if summary.missing is None else f"{summary.missing:.1%} missing"
    own = "own parameters" if summary.own_parameters else ""
    return ", ".join(filter(None, (size, missing, own)))


def last_line(entry: Entry) -> str:
    """Return the last line of a row: the user's note, or why the frame cannot be opened, or its size."""
    summary = entry.summary
    problem = summary.problem.replace(entry.key, "").lstrip(" :/\\")
    return summary.note.partition("\n")[0] or problem or size_line(summary)


def tooltip_text(entry: Entry) -> str:
    """Return the whole description of a frame, a line each."""
    summary = entry.summary
    lines = (
        entry.name,
        state_line(entry),
        summary.problem,
        size_line(summary),
        f"Note: {summary.note}" if summary.note else "",
        "Unsaved work" if entry.unsaved else "",
        entry.key,
    )
    return "\n".join(filter(None, lines))


ENTRY, PRESENT = (Qt.ItemDataRole.UserRole + number for number in range(2))


class FrameListModel(QAbstractListModel):
    """List model of the shown entries, in their order. What is edited of one is the note on it.

    Parameters
    ----------
    picture_of : callable
        Returns an entry's thumbnail, None while there is none.

    Signals
    -------
    noted(object, str)
        An entry, and the user's note on it.
    """

    noted = Signal(object, str)

    def __init__(self, picture_of: Callable[[Entry], QPixmap | None], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._picture_of = picture_of
        self.entries: list[Entry] = []
        self._rows: dict[str, int] = {}
        self.present: Entry | None = None
        """The current frame."""

    def row_of(self, entry: Entry | None) -> int:
        """Return the row of an entry; -1 if it is not shown."""
        return -1 if entry is None else self._rows.get(entry.id, -1)

    def index_of(self, entry: Entry | None) -> QModelIndex:
        """Return the model index of an entry; invalid if it is not shown."""
        row = self.row_of(entry)
        return self.index(row, 0) if row >= 0 else QModelIndex()

    def set_entries(self, entries: Sequence[Entry]) -> None:
        """Show these entries, of which any may have changed; those that stay remain current and selected."""
        wanted = list(entries)
        if wanted != self.entries:
            self.layoutAboutToBeChanged.emit()
            former = self.persistentIndexList()
            kept = [self.entries[index.row()] for index in former]
            self.entries = wanted
            self._rows = {entry.id: row for row, entry in enumerate(wanted)}
            self.changePersistentIndexList(former, [self.index_of(entry) for entry in kept])
            self.layoutChanged.emit()
        if wanted:
            self.dataChanged.emit(self.index(0, 0), self.index(len(wanted) - 1, 0))  # only visible rows are drawn

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.entries)

    def flags(self, index: Index) -> Qt.ItemFlag:
        flags = super().flags(index)
        return flags | Qt.ItemFlag.ItemIsEditable if index.isValid() else flags

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        self.noted.emit(self.entries[index.row()], value.strip())
        return True

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        if not index.isValid():
            return None
        entry = self.entries[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return entry.name
        if role == Qt.ItemDataRole.EditRole:
            return entry.note
        if role == Qt.ItemDataRole.ToolTipRole:
            return literal_text(tooltip_text(entry))
        if role == Qt.ItemDataRole.AccessibleTextRole:
            marks = [entry.note] * bool(entry.note) + ["unsaved"] * entry.unsaved
            return ", ".join((entry.name, state_line(entry), *marks))
        if role == Qt.ItemDataRole.DecorationRole:
            return self._picture_of(entry)
        if role == ENTRY:
            return entry
        return entry is self.present if role == PRESENT else None


# Filter and order of the list. No widgets.

STATES: dict[str, str] = {
    "all": "All",
    **{str(stage): stage.capitalize() for stage in Stage},
    "note": "With a note",
    "check": "To check",
    "not converged": "Not converged",
    "done": "Done",
    "not done": "Not done",
    "unsaved": "Unsaved",
}
"""States to filter by -> text."""

ORDERS: dict[str, str] = {
    "list": "As listed",
    "name": "By name",
    "state": "By state",
    "missing": "By missing",
}
"""Orders -> text."""

_RANKS = {stage: rank for rank, stage in enumerate(Stage)}
_natural = lru_cache(maxsize=20_000)(natural)

_KEYS: dict[str, Callable[[Entry], object]] = {
    "name": lambda entry: _natural(entry.name),
    "state": lambda entry: _RANKS[entry.summary.stage],
    "missing": lambda entry: -1.0 if (missing := entry.summary.missing) is None else -missing - 2,
}


def shown_entries(
    entries: Iterable[Entry], text: str = "", state: str = "all", order: str = "list", always: Entry | None = None
) -> list[Entry]:
    """Return the entries that match a filter, in order; the entry `always` is never filtered out.

    Parameters
    ----------
    entries : iterable of Entry
    text : str
        Words that must all occur in name or note.
    state : str
        One of `STATES`.
    order : str
        One of `ORDERS`.
    always : Entry or None
    """
    words = text.casefold().split()

    def matches(entry: Entry) -> bool:
        about = f"{entry.name} {entry.note}".casefold() if words else ""
        return (state == "all" or state in states_of(entry)) and all(word in about for word in words)

    through = [entry for entry in entries if entry is always or matches(entry)]
    key = _KEYS.get(order)
    return through if key is None else sorted(through, key=key)  # type: ignore[arg-type]


def states_of(entry: Entry) -> tuple[str, ...]:
    """Return all `STATES` that apply to an entry."""
    summary = entry.summary
    found = ["all", str(summary.stage)]
    found.append("done" if summary.done else "not done")
    found += ["note"] * bool(summary.note) + ["check"] * bool(summary.to_check) + ["unsaved"] * entry.unsaved
    found += ["not converged"] * bool(summary.not_converged)
    return tuple(found)


def counts(entries: Iterable[Entry]) -> Counter[str]:
    """Count the entries of each state."""
    return Counter(state for entry in entries for state in states_of(entry))
