"""Model of the table of blocks: one row per block, as text, icons, colours and sort keys."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, Qt, Signal
from PySide6.QtGui import QColor, QIcon, QPalette
from PySide6.QtWidgets import QWidget

from ilf._runtime.formatting import grouped, millimetres

from ...base import theme
from ...state.block_errors import EXPECTED
from ...widgets.basics import literal_text
from ...widgets.tables import ICON_SIZE, Index

SORT_ROLE = Qt.ItemDataRole.UserRole

# state -> icon, name of its colour in theme.Colours
_STATES = {
    "ready": ("ph.circle", "muted"),
    "queued": ("ph.clock", "muted"),
    "running": ("ph.play-circle", "accent"),
    "completed": ("ph.check-circle", "good"),
    "iteration limit": ("ph.dots-three-circle", "warning"),
    "not recoverable": ("ph.x-circle", "error"),
    "nothing missing": ("ph.minus-circle", "muted"),
    "values changed": ("ph.arrows-clockwise", "warning"),
    "edited": ("ph.pencil-simple", "warning"),
}


@dataclass(frozen=True)
class BlockRow:
    """Row of the table for one block.

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
        Number of iterations so far.
    sigma_i : float
        Deviation of the last iteration [m]; NaN if there was none.
    visible, locked : bool
    own : str
        Names of the block's own parameters; "" for none.
    look : str
        Why a propagated block needs checking; "" if it does not.
    error : float
        Root mean square error [m]; NaN if unknown.
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
    look: str = ""
    error: float = math.nan


class Column(IntEnum):
    """Columns of the table, from the left."""

    COLOUR = 0
    NAME = 1
    MISSING = 2
    ERROR = 3
    STATE = 4
    VISIBLE = 5
    LOCKED = 6
    ITERATIONS = 7
    SIGMA = 8
    PIXELS = 9


OPTIONAL = {
    Column.ERROR: "Error",
    Column.VISIBLE: "Shown",
    Column.LOCKED: "Locked",
    Column.ITERATIONS: "Iterations",
    Column.SIGMA: "Deviation \u03c3",
    Column.PIXELS: "Pixels",
}
"""Columns that the user can hide, and their names in the column menu."""
HOLD_OUT_AT_FIRST = (Column.ITERATIONS, Column.SIGMA, Column.PIXELS)

_HEADERS = {
    Column.VISIBLE: ("", "Shown in the views. Click the eye to change it; Show or hide applies to selected blocks."),
    Column.LOCKED: ("", "Locked blocks cannot be edited. Click the lock to change it."),
    Column.COLOUR: ("", "Colour in the views and plots. Click to change it."),
    Column.NAME: ("Name", "Name of the block. Press F2 to rename."),
    Column.PIXELS: ("Pixels", "Number of pixels of the block."),
    Column.MISSING: ("Missing", "Defect rate: share of the block's pixels without depth."),
    Column.ERROR: ("Error", "Root mean square error in millimetres"),
    Column.STATE: ("", "State of the block after the last run. Point at an icon for details."),
    Column.ITERATIONS: ("Iter.", "Iterations of the low-pass filter."),
    Column.SIGMA: ("σ [mm]", "Deviation sigma_i between the last two iterations, Eq. (2), in millimetres."),
}
TOOL_ICONS = {Column.VISIBLE: "ph.eye", Column.LOCKED: "ph.lock-simple", Column.COLOUR: "ph.palette"}
ICON_COLUMNS = (*TOOL_ICONS, Column.STATE)
_NUMBERS = (Column.PIXELS, Column.MISSING, Column.ERROR, Column.ITERATIONS, Column.SIGMA)


class BlockModel(QAbstractTableModel):
    """Rows of blocks, in the order of their labels; a proxy sorts them.

    Signals
    -------
    renamed(int, str)
        Label and the name that the user typed; rows change only by `set_rows`.
    """

    renamed = Signal(int, str)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.rows: list[BlockRow] = []
        self.error_source = ""
        """Reference of the errors, in words; "" if there is none."""
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
        self._look = _plain(theme.icon("ph.question", _tinted(palette, self._colours.warning)))
        self._states = {
            state: _plain(theme.icon(name, _tinted(palette, getattr(self._colours, colour))))
            for state, (name, colour) in _STATES.items()
        }
        self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(Column) - 1)
        if self.rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self.rows) - 1, len(Column) - 1))

    def set_rows(self, rows: Sequence[BlockRow]) -> None:
        """Show these rows."""
        wanted = {row.label for row in rows}
        for number in reversed(range(len(self.rows))):
            if self.rows[number].label not in wanted:
                self.beginRemoveRows(QModelIndex(), number, number)
                del self.rows[number]
                self.endRemoveRows()
        for number, row in enumerate(rows):
            if number == len(self.rows) or self.rows[number].label != row.label:
                self.beginInsertRows(QModelIndex(), number, number)
                self.rows.insert(number, row)
                self.endInsertRows()
            else:
                self._change(number, row)

    def _change(self, number: int, row: BlockRow) -> None:
        """Announce only the columns that change: other changes must not reset a name that is being edited."""
        before, self.rows[number] = self.rows[number], row
        for column in Column if before != row else ():
            # by repr: NaN is not equal to itself
            if repr(_appearance(before, column)) != repr(_appearance(row, column)):
                index = self.index(number, column)
                self.dataChanged.emit(index, index)

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
            return self._hint(column)
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
            return _SORT_KEYS[column](row)
        if role == Qt.ItemDataRole.DecorationRole:
            return self._decoration(row, column)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.ForegroundRole:
            return self._foreground(row, column)
        if role == Qt.ItemDataRole.ToolTipRole:
            if column == Column.STATE:
                return literal_text("\n".join(filter(None, (_look(row), row.state, row.detail))))
            if column == Column.NAME and (row.own or row.look):
                own = f"Own parameters: {row.own}" if row.own else ""
                return literal_text("\n".join(filter(None, (_look(row), own))))
            return self._hint(column)
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        row, name = self.rows[index.row()], str(value).strip()
        if not name or name == row.name:
            return False
        self.renamed.emit(row.label, name)
        return True

    def _hint(self, column: Column) -> str:
        hint = _HEADERS[column][1]
        if column != Column.ERROR:
            return hint
        against = "expected" if self.error_source == EXPECTED else f"against {self.error_source}"
        known = f"{hint}, {against}." if self.error_source else f"{hint}: unknown."
        return f"{known} Load ground truth or run a hold-out test in the panel Accuracy."

    def _decoration(self, row: BlockRow, column: Column) -> QIcon | QColor | None:
        if column == Column.VISIBLE:
            return self._flags[column, row.visible]
        if column == Column.LOCKED:
            return self._flags[column, row.locked]
        if column == Column.COLOUR:
            return QColor(*row.colour)
        if column == Column.NAME:
            return self._look if row.look else None
        return self._states[row.state] if column == Column.STATE else None

    def _foreground(self, row: BlockRow, column: Column) -> QColor | None:
        if not row.visible:
            return self._colours.muted
        if column == Column.ERROR and self.error_source == EXPECTED:
            return self._colours.muted
        return self._colours.accent if row.own and column == Column.NAME else None


def _appearance(row: BlockRow, column: Column) -> object:
    """Return everything that determines a cell's appearance and sort position."""
    more = {Column.STATE: (row.state, row.detail), Column.COLOUR: row.colour}.get(column)
    return _SORT_KEYS[column](row), row.visible, row.own, row.look, more


def _look(row: BlockRow) -> str:
    return f"Propagated block, needs checking: {row.look}" if row.look else ""


def _text(row: BlockRow, column: Column) -> str:
    if column == Column.NAME:
        return row.name
    if column == Column.PIXELS:
        return grouped(row.pixels)
    if column == Column.MISSING:
        return f"{100 * row.defect_rate:.1f} %"
    if column == Column.ITERATIONS:
        return str(row.iterations) if row.iterations else ""
    if column == Column.SIGMA:
        return "" if math.isnan(row.sigma_i) else f"{1000 * row.sigma_i:.3f}"
    if column == Column.ERROR:
        return millimetres(row.error)
    return ""


def _last_if_unknown(value: float) -> float:
    return math.inf if math.isnan(value) else value


# the first click on a header sorts ascending, and should show the worst block first
_SORT_KEYS: dict[Column, Callable[[BlockRow], str | float]] = {
    Column.VISIBLE: lambda row: int(row.visible),
    Column.LOCKED: lambda row: int(row.locked),
    Column.COLOUR: lambda row: QColor(*row.colour).hsvHueF(),
    # "block 10" after "block 9"
    Column.NAME: lambda row: re.sub(r"\d+", lambda digits: digits[0].zfill(9), row.name.casefold()),
    Column.PIXELS: lambda row: row.pixels,
    Column.MISSING: lambda row: -row.defect_rate,
    Column.STATE: lambda row: list(_STATES).index(row.state),
    Column.ITERATIONS: lambda row: row.iterations,
    Column.SIGMA: lambda row: _last_if_unknown(row.sigma_i),
    Column.ERROR: lambda row: _last_if_unknown(-row.error),
}


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
    """Return the icon with the same colours in selected rows."""
    pixmap = icon.pixmap(2 * ICON_SIZE, 2 * ICON_SIZE)
    plain = QIcon(pixmap)
    plain.addPixmap(pixmap, QIcon.Mode.Selected)
    return plain
