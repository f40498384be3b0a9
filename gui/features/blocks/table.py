"""The table of operation blocks: properties, state and selection."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import (
    QItemSelection,
    QItemSelectionModel,
    QModelIndex,
    QSettings,
    QSignalBlocker,
    QSortFilterProxyModel,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QColorDialog, QHeaderView, QMenu, QTableView, QWidget

from ...state.workspace import Workspace
from ...widgets.basics import Themed, paint_hint
from ...widgets.tables import RowDelegate, set_up_table
from .model import HOLD_OUT_AT_FIRST, ICON_COLUMNS, OPTIONAL, SORT_ROLE, TOOL_ICONS, BlockModel, BlockRow, Column

_WIDTHS = {Column.MISSING: 58, Column.ERROR: 52, Column.ITERATIONS: 42, Column.SIGMA: 56, Column.PIXELS: 60}
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
        self._proxy.setSortRole(SORT_ROLE)
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

    def _take_theme(self) -> None:
        self.blocks.set_palette(self.palette())

    def _indexes(self) -> list[QModelIndex]:
        return [self._proxy.index(row, Column.NAME) for row in range(self._proxy.rowCount())]

    def _row(self, index: QModelIndex) -> BlockRow:
        return self.blocks.rows[self._proxy.mapToSource(index).row()]

    def _handle_icon_click(self, event: QMouseEvent) -> bool:
        index = self.indexAt(event.position().toPoint())
        if event.button() != Qt.MouseButton.LeftButton or index.column() not in TOOL_ICONS:
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
        self.setItemDelegate(RowDelegate(ICON_COLUMNS, self))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        header = self.horizontalHeader()
        for column in Column:
            if column in ICON_COLUMNS:
                header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)
                header.resizeSection(column, _ICON_WIDTH)
            elif column != Column.NAME:
                header.resizeSection(column, _WIDTHS[column])
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(lambda at: self.column_menu().popup(header.mapToGlobal(at)))
        hidden = QSettings().value(_HIDDEN_KEY)
        names = [column.name for column in HOLD_OUT_AT_FIRST] if hidden is None else str(hidden).split()
        for column in OPTIONAL:
            self.setColumnHidden(column, column.name in names)

    def column_menu(self) -> QMenu:
        """Create the menu that shows and hides columns."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        for column, text in OPTIONAL.items():
            action = menu.addAction(text)
            action.setCheckable(True)
            action.setChecked(not self.isColumnHidden(column))
            action.toggled.connect(lambda on, column=column: self._show_column(column, on))
        return menu

    def _show_column(self, column: Column, on: bool) -> None:
        self.setColumnHidden(column, not on)
        hidden = [other.name for other in OPTIONAL if self.isColumnHidden(other)]
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
            self.edit(current.siblingAtColumn(Column.NAME))
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and current.isValid():
            self.shown.emit(self._row(current).label)
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, self.hint)
