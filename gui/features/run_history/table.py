"""Table of the run history: runs, their errors, and the selection."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

from PySide6.QtCore import QPoint, QSize, QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QPaintEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QHBoxLayout, QHeaderView, QTableView, QToolButton, QVBoxLayout, QWidget

from ilf.project.run_history import StoredRun

from ...widgets.basics import Themed, paint_hint
from ...widgets.tables import ICON_SIZE, RowDelegate, set_up_table
from .model import EDITABLE, ERROR_COLUMNS, SORT_ROLE, Column, RunModel, RunRow

_WIDTHS = {
    Column.COMPARED: 26,
    Column.COLOUR: 26,
    Column.SECONDS: 66,
    Column.ITERATIONS: 52,
    Column.GROUND_TRUTH: 86,
    Column.HOLD_OUT: 112,
    Column.EXPECTED: 190,
    Column.NOTE: 110,
}
_NAME = 0.4, 120, 240
"""Width of names: share of the width that the other columns leave, and bounds [px]."""
_VALUES_WIDTH = 120
"""Minimum width of the values [px]; below, the table scrolls horizontally."""


class RunTable(Themed, QWidget):
    """Table of the run history with its buttons. It shows rows and emits requests; only `set_rows` changes the rows.

    Parameters
    ----------
    buttons : sequence of (QAction, bool) or None
        Buttons above the table, and whether they show their text; None for a separator.

    Signals
    -------
    selectionChanged()
        The selection has changed.
    edited(object, str, str), ticked(object, bool)
        As in `RunModel`.
    deleteRequested()
        Request to delete the selected rows.
    contextMenuRequested(QPoint)
        Global position.
    shown()
        The table has become visible.
    """

    selectionChanged = Signal()
    edited = Signal(object, str, str)
    ticked = Signal(object, bool)
    deleteRequested = Signal()
    contextMenuRequested = Signal(QPoint)
    shown = Signal()

    def __init__(self, buttons: Sequence[tuple[QAction, bool] | None], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._model = RunModel(self)
        self._proxy = QSortFilterProxyModel(self)
        self._proxy.setSourceModel(self._model)
        self._proxy.setSortRole(SORT_ROLE)
        self.view = _RunView(self)
        self.view.setModel(self._proxy)
        self.view.arrange()
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.setSpacing(2)
        for button in buttons:
            if button is None:
                row.addSpacing(10)
                continue
            action, with_text = button
            tool = QToolButton(autoRaise=True)
            tool.setDefaultAction(action)
            tool.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
            if with_text:
                tool.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            row.addWidget(tool)
        row.addStretch()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(row)
        layout.addWidget(self.view, 1)
        self.setFocusProxy(self.view)
        self._model.edited.connect(self.edited)
        self._model.ticked.connect(self.ticked)
        self.view.delete_requested.connect(self.deleteRequested)
        self.view.selectionModel().selectionChanged.connect(lambda *_: self.selectionChanged.emit())
        self._model.rowsRemoved.connect(lambda *_: self.selectionChanged.emit())
        self.view.customContextMenuRequested.connect(
            lambda at: self.contextMenuRequested.emit(self.view.viewport().mapToGlobal(at))
        )

    def set_rows(self, rows: Sequence[RunRow]) -> None:
        """Show these rows, and the columns of errors that any row has; selection, scroll position and sorting stay."""
        self._model.set_rows(rows)
        known = {
            column
            for place, column in enumerate(ERROR_COLUMNS)
            if any(math.isfinite(row.errors[place] or math.nan) for row in rows)
        }
        self.view.show_errors({Column.EXPECTED, *known})

    def runs(self) -> list[StoredRun]:
        """Return all runs in table order."""
        return [self._run(row) for row in range(self._proxy.rowCount())]

    def selected(self) -> list[StoredRun]:
        """Return the selected runs in table order."""
        return [self._run(row) for row in sorted(index.row() for index in self.view.selectionModel().selectedRows())]

    def select(self, kept: StoredRun) -> None:
        """Select only this run, and scroll to it."""
        row = self.runs().index(kept)
        self.view.selectRow(row)
        self.view.scrollTo(self._proxy.index(row, Column.NAME))

    def edit(self, column: Column) -> None:
        """Edit the name or the note of the selected run in the table."""
        rows = self.view.selectionModel().selectedRows(column)
        if rows:
            index = self._proxy.index(rows[0].row(), column)
            self.view.setCurrentIndex(index)
            self.view.edit(index)

    def _take_theme(self) -> None:
        self._model.set_palette(self.palette())

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()

    def sizeHint(self) -> QSize:
        return QSize(700, 170)

    def minimumSizeHint(self) -> QSize:
        return QSize(240, 90)

    def _run(self, row: int) -> StoredRun:
        return self._model.rows[self._proxy.mapToSource(self._proxy.index(row, 0)).row()].kept


class _RunView(QTableView):
    """Mouse and keyboard of the table."""

    delete_requested = Signal()

    def arrange(self) -> None:
        """Set up columns, selection and appearance; called once, after the model is set."""
        set_up_table(self)
        self.setItemDelegate(RowDelegate((Column.COLOUR,), self, elided_within=(Column.NAME,)))
        self.setAccessibleName("Run history")
        self.setEditTriggers(QAbstractItemView.EditTrigger.DoubleClicked)
        header = self.horizontalHeader()
        for column, width in _WIDTHS.items():
            header.resizeSection(column, width)
        for column in (Column.COMPARED, Column.COLOUR):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.Fixed)

    def show_errors(self, known: Collection[Column]) -> None:
        """Show only these columns of errors."""
        for column in ERROR_COLUMNS:
            self.setColumnHidden(column, column not in known)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        others = sum(width for column, width in _WIDTHS.items() if not self.isColumnHidden(column))
        free = self.viewport().width() - others
        share, least, most = _NAME
        name = min(max(round(share * free), least), most)
        self.horizontalHeader().resizeSection(Column.NAME, name)
        self.horizontalHeader().resizeSection(Column.VALUES, max(free - name, _VALUES_WIDTH))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        current = self.currentIndex()
        if event.key() == Qt.Key.Key_F2 and current.isValid():
            column = current.column() if current.column() in EDITABLE else Column.NAME
            self.edit(current.siblingAtColumn(column))
        elif event.key() == Qt.Key.Key_Space:
            event.ignore()  # Space pans the views, regardless of the focus
        elif event.key() == Qt.Key.Key_Delete:
            self.delete_requested.emit()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self.model().rowCount() == 0:
            paint_hint(self, "Every run is listed here with its parameters and errors.")
