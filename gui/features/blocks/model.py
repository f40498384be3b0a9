"""Model of the table of blocks: one row per block, as text, icons, colours and sort keys."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, Qt
from PySide6.QtGui import QColor, QIcon, QPalette
from PySide6.QtWidgets import QWidget

from ilf._runtime.formatting import grouped, millimetres
from ilf.data.blocks import BlockInfo

from ...base import theme
from ...state.block_counts import BlockCounts
from ...state.block_errors import EXPECTED
from ...state.workspace import Workspace
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
    info : BlockInfo
        Name, colour, whether it is shown and locked.
    counts : BlockCounts
        Pixels, and the share of them without depth.
    state : str
        "ready", "queued", "running", "values changed", "edited", or the value of a `Status`.
    detail : str
        Tooltip of the state.
    iterations : int
        Number of iterations so far.
    sigma_i : float
        Deviation of the last iteration [m]; NaN if there was none.
    own : str
        Names of the block's own parameters; "" for none.
    look : str
        Why a propagated block needs checking; "" if it does not.
    error : float
        Root mean square error [m]; NaN if unknown.
    """

    label: int
    info: BlockInfo
    counts: BlockCounts
    state: str = "ready"
    detail: str = ""
    iterations: int = 0
    sigma_i: float = math.nan
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
    """Rows of blocks, in the order of their labels; a proxy sorts them. A name that the user types is an edit; rows
    change only by `set_rows`."""

    def __init__(self, workspace: Workspace, parent: QWidget) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.rows: list[BlockRow] = []
        self.error_source = ""
        """Reference of the errors, in words; "" if there is none."""
        self.set_palette(parent.palette())

    def set_palette(self, palette: QPalette) -> None:
        self._colours = theme.colours(palette)
        header_icons = {**TOOL_ICONS, Column.STATE: "ph.flag"}
        self._header_icons = {column: theme.icon(name, palette) for column, name in header_icons.items()}
        self._flags = {
            (Column.VISIBLE, True): _plain(theme.icon("ph.eye", palette)),
            (Column.VISIBLE, False): _plain(theme.icon("ph.eye-slash", palette, "muted")),
            (Column.LOCKED, True): _plain(theme.icon("ph.lock-simple", palette)),
            (Column.LOCKED, False): _plain(theme.icon("ph.lock-simple-open", palette, "muted")),
        }
        self._look = _plain(theme.icon("ph.question", palette, "warning"))
        self._states = {state: _plain(theme.icon(name, palette, tone)) for state, (name, tone) in _STATES.items()}
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
            elif repr(self.rows[number]) != repr(row):  # NaN is not equal to itself
                self.rows[number] = row
                self.dataChanged.emit(self.index(number, 0), self.index(number, len(Column) - 1))

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
            return _TEXTS[column](row) if column in _TEXTS else ""
        if role == Qt.ItemDataRole.EditRole:
            return row.info.name
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
        if not name or name == row.info.name:
            return False
        self._workspace.current.edit_info(row.label, "Rename block", name=name)
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
            return self._flags[column, row.info.visible]
        if column == Column.LOCKED:
            return self._flags[column, row.info.locked]
        if column == Column.COLOUR:
            return QColor(*row.info.colour)
        if column == Column.NAME:
            return self._look if row.look else None
        return self._states[row.state] if column == Column.STATE else None

    def _foreground(self, row: BlockRow, column: Column) -> QColor | None:
        if not row.info.visible:
            return self._colours.muted
        if column == Column.ERROR and self.error_source == EXPECTED:
            return self._colours.muted
        return self._colours.accent if row.own and column == Column.NAME else None


def _look(row: BlockRow) -> str:
    return f"Propagated block, needs checking: {row.look}" if row.look else ""


_TEXTS: dict[Column, Callable[[BlockRow], str]] = {
    Column.NAME: lambda row: row.info.name,
    Column.PIXELS: lambda row: grouped(row.counts.pixels),
    Column.MISSING: lambda row: f"{100 * row.counts.defect_rate:.1f} %",
    Column.ITERATIONS: lambda row: str(row.iterations or ""),
    Column.SIGMA: lambda row: "" if math.isnan(row.sigma_i) else f"{1000 * row.sigma_i:.3f}",
    Column.ERROR: lambda row: millimetres(row.error),
}


def _last_if_unknown(value: float) -> float:
    return math.inf if math.isnan(value) else value


# the first click on a header sorts ascending, and should show the worst block first
_SORT_KEYS: dict[Column, Callable[[BlockRow], str | float]] = {
    Column.VISIBLE: lambda row: int(row.info.visible),
    Column.LOCKED: lambda row: int(row.info.locked),
    Column.COLOUR: lambda row: QColor(*row.info.colour).hsvHueF(),
    # "block 10" after "block 9"
    Column.NAME: lambda row: re.sub(r"\d+", lambda digits: digits[0].zfill(9), row.info.name.casefold()),
    Column.PIXELS: lambda row: row.counts.pixels,
    Column.MISSING: lambda row: -row.counts.defect_rate,
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


def _plain(icon: QIcon) -> QIcon:
    """Return the icon with the same colours in selected rows."""
    pixmap = icon.pixmap(2 * ICON_SIZE, 2 * ICON_SIZE)
    plain = QIcon(pixmap)
    plain.addPixmap(pixmap, QIcon.Mode.Selected)
    return plain
