"""What the table of blocks shows: one row per block, as text, icons, colours and sort keys."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPalette
from PySide6.QtWidgets import QWidget

from gui import theme

Index = QModelIndex | QPersistentModelIndex
SORT_ROLE = Qt.ItemDataRole.UserRole
ICON_SIZE = 16

# state -> icon, and the name of its colour in theme.Colours
_STATES = {
    "ready": ("ph.circle", "muted"),
    "queued": ("ph.clock", "muted"),
    "running": ("ph.play-circle", "accent"),
    "completed": ("ph.check-circle", "good"),
    "iteration limit": ("ph.warning", "warning"),
    "not recoverable": ("ph.x-circle", "error"),
    "nothing missing": ("ph.minus-circle", "muted"),
    "values changed": ("ph.arrows-clockwise", "warning"),
    "edited": ("ph.pencil-simple", "warning"),
}


@dataclass(frozen=True)
class BlockRow:
    """What the table shows of one block.

    Attributes
    ----------
    label : int
        Label in the label map, > 0; identifies the row.
    name : str
    colour : tuple of int
        Red, green, blue, 0-255.
    pixels : int
    defect_rate : float
        Share of pixels without depth, 0-1.
    state : str
        "ready", "queued", "running", "values changed", "edited", or the value of a `Status`.
    detail : str
        Tooltip of the state.
    iterations : int
        Done so far.
    sigma_i : float
        Of the last iteration [m]; NaN where there was none.
    visible, locked : bool
    own : str
        Which parameters of the filter have values of the block's own, in words; "" for none.
    """

    label: int
    name: str
    colour: tuple[int, int, int]
    pixels: int
    defect_rate: float
    state: str = "ready"
    detail: str = ""
    iterations: int = 0
    sigma_i: float = math.nan
    visible: bool = True
    locked: bool = False
    own: str = ""


class Column(IntEnum):
    """Columns of the table, from the left."""

    COLOUR = 0
    NAME = 1
    MISSING = 2
    STATE = 3
    VISIBLE = 4
    LOCKED = 5
    ITERATIONS = 6
    SIGMA = 7
    PIXELS = 8


OPTIONAL = {
    Column.VISIBLE: "Shown",
    Column.LOCKED: "Locked",
    Column.ITERATIONS: "Iterations",
    Column.SIGMA: "Deviation \u03c3",
    Column.PIXELS: "Pixels",
}
"""Columns that the user can do without, and what they are called where that is chosen."""
HIDDEN_AT_FIRST = (Column.ITERATIONS, Column.SIGMA, Column.PIXELS)

_HEADERS = {
    Column.VISIBLE: ("", "Shown in the views. Click the eye; Show or hide does it for all chosen blocks."),
    Column.LOCKED: ("", "Locked blocks cannot be edited. Click the lock to change it."),
    Column.COLOUR: ("", "Colour in the views and plots. Click to choose another."),
    Column.NAME: ("Name", "Name of the block. Press F2 to rename."),
    Column.PIXELS: ("Pixels", "Size of the block in pixels."),
    Column.MISSING: ("Missing", "Defect rate: the share of the block's pixels without depth."),
    Column.STATE: ("", "What became of the block in the last run. Point at an icon to read it."),
    Column.ITERATIONS: ("Iter.", "Iterations of the low-pass filter."),
    Column.SIGMA: ("σ [mm]", "Deviation sigma_i between the last two iterations, Eq. (2), in millimetres."),
}
TOOL_ICONS = {Column.VISIBLE: "ph.eye", Column.LOCKED: "ph.lock-simple", Column.COLOUR: "ph.palette"}
ICON_COLUMNS = (*TOOL_ICONS, Column.STATE)
_NUMBERS = (Column.PIXELS, Column.MISSING, Column.ITERATIONS, Column.SIGMA)


class BlockModel(QAbstractTableModel):
    """Rows in the order of their labels; the view sorts by a proxy.

    Signals
    -------
    renamed(int, str)
        Label and the name that the user typed; the row itself changes by `set_rows` only.
    """

    renamed = Signal(int, str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: list[BlockRow] = []
        self.set_palette(parent.palette())

    def set_palette(self, palette: QPalette) -> None:
        self._colours = theme.colours(palette)
        header_icons = {**TOOL_ICONS, Column.STATE: "ph.flag"}
        self._header_icons = {column: theme.icon(name, palette) for column, name in header_icons.items()}
        faint = _tinted(palette, self._colours.muted)
        self._flags = {
            (Column.VISIBLE, True): _plain(theme.icon("ph.eye", palette)),
            (Column.VISIBLE, False): _plain(theme.icon("ph.eye-slash", faint)),
            (Column.LOCKED, True): _plain(theme.icon("ph.lock-simple", palette)),
            (Column.LOCKED, False): _plain(theme.icon("ph.lock-simple-open", faint)),
        }
        self._states = {
            state: _plain(theme.icon(name, _tinted(palette, getattr(self._colours, colour))))
            for state, (name, colour) in _STATES.items()
        }
        if self.rows:
            self._announce(0, len(self.rows) - 1)

    def set_rows(self, rows: Iterable[BlockRow]) -> None:
        wanted = {row.label: row for row in sorted(rows, key=lambda row: row.label)}
        for number in reversed(range(len(self.rows))):
            if self.rows[number].label not in wanted:
                self.beginRemoveRows(QModelIndex(), number, number)
                del self.rows[number]
                self.endRemoveRows()
        for number, row in enumerate(wanted.values()):
            if number == len(self.rows) or self.rows[number].label != row.label:
                self.beginInsertRows(QModelIndex(), number, number)
                self.rows.insert(number, row)
                self.endInsertRows()
            # NaN in sigma_i is not equal to itself, its text is
            elif self.rows[number] != row and repr(self.rows[number]) != repr(row):
                self._change(number, row)

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(self.rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008
        return 0 if parent.isValid() else len(Column)

    def flags(self, index: Index) -> Qt.ItemFlag:
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        return flags | Qt.ItemFlag.ItemIsEditable if index.column() == Column.NAME else flags

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = Column(section)
        if role == Qt.ItemDataRole.DisplayRole:
            return _HEADERS[column][0]
        if role == Qt.ItemDataRole.ToolTipRole:
            return _HEADERS[column][1]
        if role == Qt.ItemDataRole.DecorationRole:
            return self._header_icons.get(column)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        return None

    def data(self, index: Index, role: int = 0) -> Any:
        row, column = self.rows[index.row()], Column(index.column())
        if role == Qt.ItemDataRole.DisplayRole:
            return _text(row, column)
        if role == Qt.ItemDataRole.EditRole:
            return row.name
        if role == SORT_ROLE:
            return _sort_key(row, column)
        if role == Qt.ItemDataRole.DecorationRole:
            return self._decoration(row, column)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.ForegroundRole:
            return self._foreground(row, column)
        if role == Qt.ItemDataRole.ToolTipRole:
            if column == Column.STATE:
                return f"{row.state}\n{row.detail}".strip()
            if column == Column.NAME and row.own:
                return f"Has values of its own: {row.own}"
            return _HEADERS[column][1]
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        row, name = self.rows[index.row()], str(value).strip()
        if not name or name == row.name:
            return False
        self.renamed.emit(row.label, name)
        return True

    def _change(self, number: int, row: BlockRow) -> None:
        """Announce just the columns that change: a name that is being typed must not be reset by the others."""
        before, self.rows[number] = self.rows[number], row
        for column in Column:
            if repr(_sort_key(before, column)) != repr(_sort_key(row, column)) or column in (
                Column.STATE,
                Column.COLOUR,
            ):
                index = self.index(number, column)
                self.dataChanged.emit(index, index)
        if (before.visible, before.own) != (row.visible, row.own):
            self._announce(number, number)

    def _announce(self, first: int, last: int) -> None:
        self.dataChanged.emit(self.index(first, 0), self.index(last, len(Column) - 1))

    def _decoration(self, row: BlockRow, column: Column) -> QIcon | QColor | None:
        if column == Column.VISIBLE:
            return self._flags[column, row.visible]
        if column == Column.LOCKED:
            return self._flags[column, row.locked]
        if column == Column.COLOUR:
            return QColor(*row.colour)
        return self._states[row.state] if column == Column.STATE else None

    def _foreground(self, row: BlockRow, column: Column) -> QColor | None:
        if not row.visible:
            return self._colours.muted
        return self._colours.accent if row.own and column == Column.NAME else None


def _text(row: BlockRow, column: Column) -> str:
    if column == Column.NAME:
        return row.name
    if column == Column.PIXELS:
        return f"{row.pixels:,}".replace(",", "\u202f")
    if column == Column.MISSING:
        return f"{100 * row.defect_rate:.1f} %"
    if column == Column.ITERATIONS:
        return str(row.iterations) if row.iterations else ""
    if column == Column.SIGMA:
        return "" if math.isnan(row.sigma_i) else f"{1000 * row.sigma_i:.3f}"
    return ""


def _sort_key(row: BlockRow, column: Column) -> str | float:
    keys: dict[Column, str | float] = {
        Column.VISIBLE: int(row.visible),
        Column.LOCKED: int(row.locked),
        Column.COLOUR: QColor(*row.colour).hsvHueF(),
        # "block 10" after "block 9"
        Column.NAME: re.sub(r"\d+", lambda digits: digits[0].zfill(9), row.name.casefold()),
        Column.PIXELS: row.pixels,
        Column.MISSING: row.defect_rate,
        Column.STATE: list(_STATES).index(row.state),
        Column.ITERATIONS: row.iterations,
        Column.SIGMA: math.inf if math.isnan(row.sigma_i) else row.sigma_i,
    }
    return keys[column]


def _alignment(column: Column) -> Qt.AlignmentFlag:
    if column in ICON_COLUMNS:
        return Qt.AlignmentFlag.AlignCenter
    side = Qt.AlignmentFlag.AlignRight if column in _NUMBERS else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


def _tinted(palette: QPalette, colour: QColor) -> QPalette:
    tinted = QPalette(palette)
    tinted.setColor(QPalette.ColorRole.WindowText, colour)
    return tinted


def _plain(icon: QIcon) -> QIcon:
    """The icon in the same colours whether its row is selected or not."""
    pixmap = icon.pixmap(2 * ICON_SIZE, 2 * ICON_SIZE)
    plain = QIcon(pixmap)
    plain.addPixmap(pixmap, QIcon.Mode.Selected)
    return plain
