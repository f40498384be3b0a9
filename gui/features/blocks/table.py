"""The table of operation blocks: one row per block, with its properties and state, and the selection."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from enum import IntEnum

from PySide6.QtCore import QItemSelection, QItemSelectionModel, QModelIndex, QSettings, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QColorDialog, QMenu

from ilf._runtime.formatting import grouped, millimetres, natural
from ilf.data.blocks import BlockInfo

from ...state.frame_data import BlockCounts
from ...state.workspace import Workspace
from ...widgets.row_table import Heading, RowTable, TableCell, TableCells

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


class BlockColumn(IntEnum):
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


_ALWAYS = (BlockColumn.COLOUR, BlockColumn.NAME, BlockColumn.MISSING, BlockColumn.STATE)
_OPTIONAL = [column for column in BlockColumn if column not in _ALWAYS]
"""Columns that the user can hide."""
_HIDDEN_AT_FIRST = (BlockColumn.ITERATIONS, BlockColumn.SIGMA, BlockColumn.PIXELS)
_CLICKED = (BlockColumn.VISIBLE, BlockColumn.LOCKED, BlockColumn.COLOUR)

_ERROR = (
    "Root mean square error in millimetres: against ground truth or hold-out depth, or grey as expected. Load ground "
    "truth or run a hold-out test in the panel Accuracy."
)
_HEADINGS: dict[int, Heading] = {
    BlockColumn.COLOUR: Heading(
        "", "Colour in the views and plots. Click to change it.", kind="icon", icon="ph.palette"
    ),
    BlockColumn.NAME: Heading("Name", "Name of the block. Press F2 to rename.", kind="edited"),
    BlockColumn.MISSING: Heading("Missing", "Defect rate: share of the block's pixels without depth.", 58, "number"),
    BlockColumn.ERROR: Heading("Error [mm]", _ERROR, 48, "number"),
    BlockColumn.STATE: Heading(
        "", "State of the block after the last run. Point at an icon for details.", kind="icon", icon="ph.flag"
    ),
    BlockColumn.VISIBLE: Heading(
        "",
        "Shown in the views. Click the eye to change it; Show or hide applies to selected blocks.",
        kind="icon",
        icon="ph.eye",
    ),
    BlockColumn.LOCKED: Heading(
        "", "Locked blocks cannot be edited. Click the lock to change it.", kind="icon", icon="ph.lock-simple"
    ),
    BlockColumn.ITERATIONS: Heading("Iter.", "Iterations of the low-pass filter.", 42, "number"),
    BlockColumn.SIGMA: Heading(
        "σ [mm]", "Deviation sigma_i between the last two iterations, Eq. (2), in millimetres.", 56, "number"
    ),
    BlockColumn.PIXELS: Heading("Pixels", "Number of pixels of the block.", 60, "number"),
}


def block_cells(
    info: BlockInfo,
    counts: BlockCounts,
    state: str = "ready",
    detail: str = "",
    iterations: int = 0,
    sigma_i: float = math.nan,
    *,
    own: str = "",
    look: str = "",
    error: float = math.nan,
    error_is_expected: bool = False,
) -> TableCells:
    """Return what the table shows of a block. The first click on a header sorts ascending, and should show the worst
    block first.

    Parameters
    ----------
    info : BlockInfo
    counts : BlockCounts
    state, detail : str
        "ready", "queued", "running", "values changed", "edited", or the value of a `Status`; and the tooltip of it.
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
    error_is_expected : bool
        Whether it is an estimate only.
    """
    look = f"Propagated block, needs checking: {look}" if look else ""
    own = f"Own parameters: {own}" if own else ""
    tone = "" if info.visible else "muted"
    of_error = tone or ("muted" if error_is_expected else "")
    sigma = "" if math.isnan(sigma_i) else f"{1000 * sigma_i:.3f}"
    return {
        BlockColumn.COLOUR: TableCell(key=QColor(*info.colour).hsvHueF(), icon=info.colour),
        BlockColumn.NAME: TableCell(
            info.name,
            natural(info.name),
            _lines(look, own),
            ("ph.question", "warning") if look else None,
            tone or ("accent" if own else ""),
        ),
        BlockColumn.MISSING: TableCell(f"{100 * counts.defect_rate:.1f} %", -counts.defect_rate, tone=tone),
        BlockColumn.ERROR: TableCell(millimetres(error), _last_if_unknown(-error), tone=of_error),
        BlockColumn.STATE: TableCell(
            key=list(_STATES).index(state), hint=_lines(look, state, detail), icon=_STATES[state]
        ),
        BlockColumn.VISIBLE: TableCell(
            key=int(info.visible), icon=("ph.eye", "text") if info.visible else ("ph.eye-slash", "muted")
        ),
        BlockColumn.LOCKED: TableCell(
            key=int(info.locked),
            icon=("ph.lock-simple", "text") if info.locked else ("ph.lock-simple-open", "muted"),
        ),
        BlockColumn.ITERATIONS: TableCell(str(iterations or ""), iterations, tone=tone),
        BlockColumn.SIGMA: TableCell(sigma, _last_if_unknown(sigma_i), tone=tone),
        BlockColumn.PIXELS: TableCell(grouped(counts.pixels), counts.pixels, tone=tone),
    }


def _lines(*texts: str) -> str:
    return "\n".join(filter(None, texts))


def _last_if_unknown(value: float) -> float:
    return math.inf if math.isnan(value) else value


_HIDDEN_KEY = "blocks/hidden_columns"
_NAME_WIDTH = 58  # minimum; in less width, the table scrolls sideways


class BlockTable(RowTable):
    """Table of the blocks of the current frame. What the user does in it is an edit; rows change only by `set_rows`.

    Signals
    -------
    labelsSelected(list of int)
        Labels in table order, after the user selected.
    shown(int)
        Double-click or Enter: show this block.
    """

    labelsSelected = Signal(list)
    shown = Signal(int)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__("Blocks", _HEADINGS)
        self._workspace = workspace
        self.rows.edited.connect(self._rename)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        header = self.horizontalHeader()
        header.setMinimumHeight(2 * self.fontMetrics().height() + 6)  # of headings in two lines
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(lambda at: self.column_menu().popup(header.mapToGlobal(at)))
        hidden = QSettings().value(_HIDDEN_KEY)
        names = [column.name for column in _HIDDEN_AT_FIRST] if hidden is None else str(hidden).split()
        for column in _OPTIONAL:
            self.setColumnHidden(column, column.name in names)
        self.selectionModel().selectionChanged.connect(lambda *_: self.labelsSelected.emit(self.chosen()))

    def set_rows(self, rows: Mapping[int, TableCells]) -> None:
        """Show the cells of blocks by their labels; selection, scroll position and sorting stay, equal rows are not
        updated.

        `labelsSelected` is not emitted: the caller knows the removed rows.
        """
        with QSignalBlocker(self):
            self.rows.show_rows(dict(sorted(rows.items())))

    def select(self, labels: Iterable[int]) -> None:
        """Select these blocks and no others, and bring the first into view; `labelsSelected` is not emitted."""
        wanted = set(labels)
        selection = QItemSelection()
        found = [index for index in self._indexes() if self.key_of(index) in wanted]
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
        return [self.key_of(index) for index in self._indexes()]

    def _indexes(self) -> list[QModelIndex]:
        return [self.proxy.index(row, BlockColumn.NAME) for row in range(self.proxy.rowCount())]

    def _rename(self, label: int, column: int, name: str) -> None:
        if name:
            self._workspace.current.edit_info(label, "Rename block", name=name)

    def _handle_icon_click(self, event: QMouseEvent) -> bool:
        index = self.indexAt(event.position().toPoint())
        if event.button() != Qt.MouseButton.LeftButton or index.column() not in _CLICKED:
            return False
        label, document = self.key_of(index), self._workspace.current
        info = document.info(label)
        if index.column() == BlockColumn.VISIBLE:
            document.set_visible(label, not info.visible)
        elif index.column() == BlockColumn.LOCKED:
            document.set_lock(label, not info.locked)
        else:
            colour = QColorDialog.getColor(QColor(*info.colour), self, f"Colour of {info.name}")
            rgb = colour.red(), colour.green(), colour.blue()
            if colour.isValid() and rgb != tuple(info.colour):
                document.edit_info(label, "Recolour block", colour=rgb)
        return True

    def column_menu(self) -> QMenu:
        """Create the menu that shows and hides columns."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for column in _OPTIONAL:
            action = menu.addAction(column.name.capitalize())
            action.setCheckable(True)
            action.setChecked(not self.isColumnHidden(column))
            action.toggled.connect(lambda on, column=column: self._show_column(column, on))
        return menu

    def _show_column(self, column: BlockColumn, on: bool) -> None:
        self.setColumnHidden(column, not on)
        hidden = [other.name for other in _OPTIONAL if self.isColumnHidden(other)]
        QSettings().setValue(_HIDDEN_KEY, " ".join(hidden))
        self._fit_names()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit_names()

    def _fit_names(self) -> None:
        header = self.horizontalHeader()
        others = header.length() - header.sectionSize(BlockColumn.NAME)
        header.resizeSection(BlockColumn.NAME, max(_NAME_WIDTH, self.viewport().width() - others))

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
            self.shown.emit(self.key_of(index))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        current, edited = self.currentIndex(), self.state() == self.State.EditingState  # the editor passes on its Enter
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and current.isValid() and not edited:
            self.shown.emit(self.key_of(current))
        else:
            super().keyPressEvent(event)
