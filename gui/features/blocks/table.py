"""The table of operation blocks: one row per block, with its properties and state, and the selection."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QSettings,
    QSignalBlocker,
    QSortFilterProxyModel,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QIcon, QKeyEvent, QMouseEvent, QPaintEvent, QPalette, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QColorDialog, QHeaderView, QMenu, QTableView, QWidget

from ilf._runtime.formatting import grouped, millimetres
from ilf.data.blocks import BlockInfo

from ...base import theme
from ...state.blocks import EXPECTED, BlockCounts
from ...state.workspace import Workspace
from ...widgets.basics import Themed, literal_text, paint_hint
from ...widgets.tables import ICON_SIZE, Index, RowDelegate, set_up_table

_SORT_ROLE = Qt.ItemDataRole.UserRole

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


_OPTIONAL = {
    Column.ERROR: "Error",
    Column.VISIBLE: "Shown",
    Column.LOCKED: "Locked",
    Column.ITERATIONS: "Iterations",
    Column.SIGMA: "Deviation \u03c3",
    Column.PIXELS: "Pixels",
}
"""Columns that the user can hide, and their names in the column menu."""
_HIDDEN_AT_FIRST = (Column.ITERATIONS, Column.SIGMA, Column.PIXELS)

_HEADERS = {
    Column.VISIBLE: ("", "Shown in the views. Click the eye to change it; Show or hide applies to selected blocks."),
    Column.LOCKED: ("", "Locked blocks cannot be edited. Click the lock to change it."),
    Column.COLOUR: ("", "Colour in the views and plots. Click to change it."),
    Column.NAME: ("Name", "Name of the block. Press F2 to rename."),
    Column.PIXELS: ("Pixels", "Number of pixels of the block."),
    Column.MISSING: ("Missing", "Defect rate: share of the block's pixels without depth."),
    Column.ERROR: ("Error [mm]", "Root mean square error in millimetres"),
    Column.STATE: ("", "State of the block after the last run. Point at an icon for details."),
    Column.ITERATIONS: ("Iter.", "Iterations of the low-pass filter."),
    Column.SIGMA: ("σ [mm]", "Deviation sigma_i between the last two iterations, Eq. (2), in millimetres."),
}
_TOOL_ICONS = {Column.VISIBLE: "ph.eye", Column.LOCKED: "ph.lock-simple", Column.COLOUR: "ph.palette"}
_ICON_COLUMNS = (*_TOOL_ICONS, Column.STATE)
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
        header_icons = {**_TOOL_ICONS, Column.STATE: "ph.flag"}
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
        if role == _SORT_ROLE:
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
    if column in _ICON_COLUMNS:
        return Qt.AlignmentFlag.AlignCenter
    side = Qt.AlignmentFlag.AlignRight if column in _NUMBERS else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


def _plain(icon: QIcon) -> QIcon:
    """Return the icon with the same colours in selected rows."""
    pixmap = icon.pixmap(2 * ICON_SIZE, 2 * ICON_SIZE)
    plain = QIcon(pixmap)
    plain.addPixmap(pixmap, QIcon.Mode.Selected)
    return plain


_WIDTHS = {Column.MISSING: 58, Column.ERROR: 84, Column.ITERATIONS: 42, Column.SIGMA: 56, Column.PIXELS: 60}
_ICON_WIDTH = 26
_HIDDEN_KEY = "blocks/hidden_columns"
_NAME_WIDTH = 58  # minimum; in less width, the table scrolls sideways


class BlockTable(Themed, QTableView):
    """Table of the blocks of the current frame. What the user does in it is an edit; rows change only by `set_rows`.

    Attributes
    ----------
    hint : str
        Text of the empty table.

    Signals
    -------
    labelsSelected(list of int)
        Labels in table order, after the user selected.
    shown(int)
        Double-click or Enter: show this block.
    """

    labelsSelected = Signal(list)
    shown = Signal(int)

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.hint = ""
        self.blocks = BlockModel(workspace, self)
        self._proxy = QSortFilterProxyModel(self)
        self._proxy.setSourceModel(self.blocks)
        self._proxy.setSortRole(_SORT_ROLE)
        self.setAccessibleName("Blocks")
        self.setModel(self._proxy)
        self._arrange()
        self.selectionModel().selectionChanged.connect(lambda *_: self.labelsSelected.emit(self.selected()))

    def set_rows(self, rows: Iterable[BlockRow]) -> None:
        """Show these rows; selection, scroll position and sorting stay, equal rows are not updated.

        `labelsSelected` is not emitted: the caller knows the removed rows.
        """
        with QSignalBlocker(self):
            self.blocks.set_rows(sorted(rows, key=lambda row: row.label))

    def select(self, labels: Iterable[int]) -> None:
        """Select these blocks and no others, and bring the first into view; `labelsSelected` is not emitted."""
        wanted = set(labels)
        selection = QItemSelection()
        found = [index for index in self._indexes() if self._row(index).label in wanted]
        for index in found:
            selection.select(index, index)
        flags = QItemSelectionModel.SelectionFlag
        with QSignalBlocker(self):
            self.selectionModel().select(selection, flags.ClearAndSelect | flags.Rows)
            if found:
                self.selectionModel().setCurrentIndex(found[0], flags.NoUpdate)
                self.scrollTo(found[0])

    def labels(self) -> list[int]:
        """Labels of all blocks in table order."""
        return [self._row(index).label for index in self._indexes()]

    def selected(self) -> list[int]:
        """Labels of the selected blocks in table order."""
        rows = sorted(index.row() for index in self.selectionModel().selectedRows())
        return [self._row(self._proxy.index(row, 0)).label for row in rows]

    def rename(self) -> None:
        """Let the user edit the name of the current block."""
        self.edit(self.currentIndex().siblingAtColumn(Column.NAME))

    def _take_theme(self) -> None:
        self.blocks.set_palette(self.palette())

    def _indexes(self) -> list[QModelIndex]:
        return [self._proxy.index(row, Column.NAME) for row in range(self._proxy.rowCount())]

    def _row(self, index: QModelIndex) -> BlockRow:
        return self.blocks.rows[self._proxy.mapToSource(index).row()]

    def _handle_icon_click(self, event: QMouseEvent) -> bool:
        index = self.indexAt(event.position().toPoint())
        if event.button() != Qt.MouseButton.LeftButton or index.column() not in _TOOL_ICONS:
            return False
        row = self._row(index)
        if index.column() == Column.VISIBLE:
            self._workspace.current.set_visible(row.label, not row.info.visible)
        elif index.column() == Column.LOCKED:
            self._workspace.current.set_lock(row.label, not row.info.locked)
        else:
            colour = QColorDialog.getColor(QColor(*row.info.colour), self, f"Colour of {row.info.name}")
            if colour.isValid():
                rgb = colour.red(), colour.green(), colour.blue()
                self._workspace.current.edit_info(row.label, "Recolour block", colour=rgb)
        return True

    def _arrange(self) -> None:
        """Set up columns, selection and style; after the model is set."""
        set_up_table(self, _ICON_WIDTH)
        self.setItemDelegate(RowDelegate(_ICON_COLUMNS, self))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        header = self.horizontalHeader()
        for column in Column:
            if column in _ICON_COLUMNS:
                header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
                header.resizeSection(column, _ICON_WIDTH)
            elif column != Column.NAME:
                header.resizeSection(column, _WIDTHS[column])
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(lambda at: self.column_menu().popup(header.mapToGlobal(at)))
        hidden = QSettings().value(_HIDDEN_KEY)
        names = [column.name for column in _HIDDEN_AT_FIRST] if hidden is None else str(hidden).split()
        for column in _OPTIONAL:
            self.setColumnHidden(column, column.name in names)

    def column_menu(self) -> QMenu:
        """Create the menu that shows and hides columns."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for column, text in _OPTIONAL.items():
            action = menu.addAction(text)
            action.setCheckable(True)
            action.setChecked(not self.isColumnHidden(column))
            action.toggled.connect(lambda on, column=column: self._show_column(column, on))
        return menu

    def _show_column(self, column: Column, on: bool) -> None:
        self.setColumnHidden(column, not on)
        hidden = [other.name for other in _OPTIONAL if self.isColumnHidden(other)]
        QSettings().setValue(_HIDDEN_KEY, " ".join(hidden))
        self._fit_names()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_names()

    def _fit_names(self) -> None:
        header = self.horizontalHeader()
        others = header.length() - header.sectionSize(Column.NAME)
        header.resizeSection(Column.NAME, max(_NAME_WIDTH, self.viewport().width() - others))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if not self._handle_icon_click(event):
            super().mousePressEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        # the second of two quick clicks on an eye toggles it again
        if self._handle_icon_click(event):
            return
        super().mouseDoubleClickEvent(event)
        index = self.indexAt(event.position().toPoint())
        if index.isValid() and event.button() == Qt.MouseButton.LeftButton:
            self.shown.emit(self._row(index).label)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        current = self.currentIndex()
        if event.key() == Qt.Key.Key_Space:
            event.ignore()  # Space pans the views and changes no block
        elif event.key() == Qt.Key.Key_F2 and current.isValid():
            self.rename()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and current.isValid():
            self.shown.emit(self._row(current).label)
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)
