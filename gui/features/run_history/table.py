"""The table of runs: the columns that tell runs apart first."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QColor, QFont, QKeyEvent, QPaintEvent, QResizeEvent, QStandardItem, QStandardItemModel
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableView,
    QWidget,
)

from ilf._runtime.formatting import UNKNOWN, counted, millimetres
from ilf.completion.confidence.expected_error import RMS_MEANING, RMS_NAME
from ilf.data.parameters import PRESETS, Parameters, nearest_preset
from ilf.project.run_history import StoredRun

from ...base import theme
from ...state.document import Document
from ...state.run_history import MAX_COMPARED, parameters_text, title_of
from ...widgets.basics import literal_text, paint_hint
from ...widgets.tables import RowDelegate, set_up_table


class Column(IntEnum):
    """Columns of the table, from the left."""

    COMPARED = 0
    NAME = 1
    GROUND_TRUTH = 2
    HOLD_OUT = 3
    EXPECTED = 4
    VALUES = 5
    SECONDS = 6
    ITERATIONS = 7
    NOTE = 8


ERRORS = {
    Column.GROUND_TRUTH: "ground_truth_error",
    Column.HOLD_OUT: "hold_out_error",
    Column.EXPECTED: "expected_error",
}
"""Columns of errors, and the attributes of `StoredRun` with them."""

_WIDTHS = {
    Column.COMPARED: 26,
    Column.GROUND_TRUTH: 66,
    Column.HOLD_OUT: 76,
    Column.EXPECTED: 80,
    Column.SECONDS: 60,
    Column.ITERATIONS: 52,
    Column.NOTE: 110,
}
_LEAST_NAME, _MOST_NAME, _LEAST_VALUES = 92, 220, 76
"""Widths of names and values, which share what the other columns leave [px]."""

_COMPARABLE = 0.9
"""Minimum number of filled pixels of a best run, as a share of the largest number of any run."""
_NUMBERS = (*ERRORS, Column.SECONDS, Column.ITERATIONS)
_SORT_ROLE = Qt.ItemDataRole.UserRole
_BEST = (
    "Bold with a star: best of the runs that have filled about as many pixels, or equal to it as shown. The panel "
    "Accuracy compares runs on the same pixels."
)
_HEADERS = {
    Column.COMPARED: ("", f"Compare: show the run beside the current result (max. {MAX_COMPARED}). Click the tick."),
    Column.NAME: (
        "Run",
        "Name of the run, in its colour in curves and profiles; a dot marks the run whose results are shown "
        "now. Press F2 to rename.",
    ),
    Column.GROUND_TRUTH: (
        "Truth [mm]",
        f"Root mean square error against the frame's ground truth, over the pixels filled by blocks. {_BEST}",
    ),
    Column.HOLD_OUT: (
        "Hold-out [mm]",
        "Root mean square error on hold-out depth with the run's parameters: hold-out test in the panel Accuracy. "
        f"{_BEST}",
    ),
    Column.EXPECTED: (f"{RMS_NAME} [mm]", f"{RMS_MEANING}. {_BEST}"),
    Column.VALUES: ("Values", "The nearest preset, and the differences to it."),
    Column.SECONDS: ("Time [s]", "Duration of the run in seconds."),
    Column.ITERATIONS: ("Iter.", "Iterations of the low-pass filter in all blocks of the run."),
    Column.NOTE: (
        "Note",
        "Your note on the run. Double-click to edit; runs with a note are not deleted automatically.",
    ),
}


class _Cell(NamedTuple):
    text: str
    key: str | float
    tooltip: str
    strong: bool = False


def values_of(document: Document, run: StoredRun) -> str:
    """Describe how a run differs from the nearest preset, and what is missing for a complete run of all blocks with
    its own parameters."""
    texts = [parameters_text(document, run.run), "" if run.how == "finished" else run.how]
    missing = run.block_count - len(run.results)
    for count, what in ((missing, "without result"), (len(run.outdated), "with other parameters")):
        texts.append(f"{count} of {run.block_count} blocks {what}" if count else "")
    first, *others = texts
    return " · ".join(filter(None, (first, ", ".join(filter(None, others)))))


def _cells(document: Document, run: StoredRun, present: bool, best: frozenset[Column]) -> dict[Column, _Cell]:
    """Return what the table shows of a run; `best` are the errors that no other run has smaller."""
    title, values = title_of(run.name, document, run.run), values_of(document, run)
    # "Run 10" after "Run 9"
    name_key = re.sub(r"\d+", lambda digits: digits[0].zfill(9), run.name.casefold())
    seconds = f"{run.seconds:.2f}" if run.seconds else UNKNOWN
    about = (
        f"{run.name}\n{run.when:%H:%M:%S}: {len(run.done)} of {run.block_count} blocks in {seconds} s, "
        f"{run.iterations} iterations, {run.how}.\n{counted(run.recovered, 'pixel')} filled by blocks"
        f"{'' if run.extrapolation is None else ', the rest extrapolated'}."
        f"{' Its results are the current ones.' if present else ''}"
    )
    compared = run in document.compared
    return {
        Column.COMPARED: _Cell("", not compared, _HEADERS[Column.COMPARED][1], compared),
        Column.NAME: _Cell(f"● {title}" if present else title, name_key, about, present),
        **{column: _error_cell(run, column, column in best) for column in ERRORS},
        Column.VALUES: _Cell(values, values.casefold(), _all_values(run.run.parameters, values)),
        Column.SECONDS: _Cell(seconds, run.seconds, _HEADERS[Column.SECONDS][1]),
        Column.ITERATIONS: _Cell(str(run.iterations), run.iterations, _HEADERS[Column.ITERATIONS][1]),
        Column.NOTE: _Cell(run.note, run.note.casefold(), run.note or _HEADERS[Column.NOTE][1]),
    }


def _error_cell(run: StoredRun, column: Column, best: bool) -> _Cell:
    error: float | None = getattr(run, ERRORS[column])
    hint = _HEADERS[column][1]
    if error is None:
        return _Cell("", math.inf, f"{hint} It has not been computed.")
    if math.isnan(error):
        return _Cell(millimetres(error), math.inf, f"{hint} It is not defined for this run.")
    if column == Column.HOLD_OUT and run.hold_out_test is not None:
        test = run.hold_out_test
        hint = f"{hint} Hold-out: {test.pattern}, seeds {', '.join(map(str, test.seeds))}."
    return _Cell(f"★ {millimetres(error)}" if best else millimetres(error), error, hint, best)


def _all_values(parameters: Parameters, values: str) -> str:
    """Return all parameters that have an effect as rich text; those that differ from the preset are bold."""
    differs = nearest_preset(parameters, PRESETS).differs
    lines = []
    for name, declaration in Parameters.declarations().items():
        if parameters.has_effect(name):
            text = html.escape(f"{declaration.label}: {declaration.to_text(getattr(parameters, name))}")
            lines.append(f"<b>{text}</b>" if name in differs else text)
    return f"<p>{html.escape(values)}</p><p>{'<br>'.join(lines)}</p>"


def best_of(runs: Sequence[StoredRun], error: str) -> list[StoredRun]:
    """Return the runs with the smallest error of a kind, several if it is the same in the digits that are shown, of
    those that have filled about as many pixels as any, and for hold-out errors were tested like most; none if fewer
    than two are comparable, or if all of these are equal."""
    most = max((run.recovered for run in runs), default=0)
    values = [(run, getattr(run, error)) for run in runs if run.recovered >= _COMPARABLE * most]
    evaluated = [(run, value) for run, value in values if value is not None and math.isfinite(value)]
    if error == "hold_out_error" and evaluated:
        tests = [run.hold_out_test for run, _ in evaluated]
        usual = max(reversed(tests), key=tests.count)
        evaluated = [(run, value) for run, value in evaluated if run.hold_out_test == usual]
    smallest = millimetres(min((value for _, value in evaluated), default=math.nan))
    best = [run for run, value in evaluated if millimetres(value) == smallest]
    return best if len(best) < len(evaluated) else []


class RunModel(QStandardItemModel):
    """One row per run, the latest first. What the user changes is passed on: the history changes, then the row.

    Signals
    -------
    edited(object, str, object)
        A stored run, "name", "note" or "compared", and the new value.
    """

    edited = Signal(object, str, object)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(0, len(Column), parent)
        self.runs: list[StoredRun] = []
        """The run of every row."""
        self._parent = parent
        for column, (text, hint) in _HEADERS.items():
            header = QStandardItem(text)
            header.setToolTip(hint)
            header.setAccessibleText(text or "Compare")
            self.setHorizontalHeaderItem(column, header)

    def show_runs(self, document: Document | None) -> None:
        """Show the runs of a frame. Items tell only of what changes, so that editors stay open."""
        runs = [] if document is None else list(reversed(document.state.runs))
        for row in reversed(range(len(self.runs))):
            if self.runs[row] not in runs:
                del self.runs[row]
                self.removeRow(row)
        present = {} if document is None else document.valid_results()
        best = {column: best_of(runs[::-1], error) for column, error in ERRORS.items()}
        for row, run in enumerate(runs):
            if row == len(self.runs) or self.runs[row] is not run:
                self.runs.insert(row, run)
                self.insertRow(row, [_item(run, column) for column in Column])
            if document is not None:
                smallest = frozenset(column for column, those in best.items() if run in those)
                self._draw(row, _cells(document, run, run.is_of(present), smallest))

    def _draw(self, row: int, cells: dict[Column, _Cell]) -> None:
        for column, cell in cells.items():
            item = self.item(row, column)
            if column == Column.COMPARED:
                item.setCheckState(Qt.CheckState.Checked if cell.strong else Qt.CheckState.Unchecked)
            font = QFont(self._parent.font())
            font.setBold(cell.strong)
            item.setFont(font)
            item.setText(cell.text)
            item.setToolTip(literal_text(cell.tooltip) if column != Column.VALUES else cell.tooltip)
            item.setData(cell.key, _SORT_ROLE)
        name = self.item(row, Column.NAME)
        name.setData(QColor(*self.runs[row].colour), Qt.ItemDataRole.DecorationRole)
        name.setAccessibleText(f"{name.text()}, current" if cells[Column.NAME].strong else name.text())
        self.item(row, Column.COMPARED).setAccessibleText(f"Compare {self.runs[row].name}")

    def data(self, index: QModelIndex | QPersistentModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        column = index.column()
        if role == Qt.ItemDataRole.EditRole and column == Column.NAME:
            return self.runs[index.row()].name
        if role == Qt.ItemDataRole.ForegroundRole and column in ERRORS:
            best = self.item(index.row(), column).font().bold()
            return theme.colours(self._parent.palette()).good if best else None
        return super().data(index, role)

    def setData(
        self, index: QModelIndex | QPersistentModelIndex, value: Any, role: int = Qt.ItemDataRole.EditRole
    ) -> bool:
        run = self.runs[index.row()]
        if role == Qt.ItemDataRole.CheckStateRole:
            self.edited.emit(run, "compared", Qt.CheckState(value) == Qt.CheckState.Checked)
            return True
        what, text = "note" if index.column() == Column.NOTE else "name", str(value).strip()
        if text == getattr(run, what) or (what == "name" and not text):
            return False
        self.edited.emit(run, what, text)
        return True


def _item(run: StoredRun, column: Column) -> QStandardItem:
    item = QStandardItem()
    item.setEditable(column in (Column.NAME, Column.NOTE))
    item.setCheckable(column == Column.COMPARED)
    side = Qt.AlignmentFlag.AlignRight if column in _NUMBERS else Qt.AlignmentFlag.AlignLeft
    item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
    return item


class RunView(QTableView):
    """The table; it shares its width among the columns, and shows the columns of errors that any run has."""

    delete_requested = Signal()

    def __init__(self, model: RunModel) -> None:
        super().__init__()
        self.proxy = QSortFilterProxyModel(self)
        self.proxy.setSourceModel(model)
        self.proxy.setSortRole(_SORT_ROLE)
        self.setModel(self.proxy)
        set_up_table(self)
        self.setItemDelegate(RowDelegate((), self))
        self.setAccessibleName("Run history")
        self.setEditTriggers(QAbstractItemView.EditTrigger.DoubleClicked)
        header = self.horizontalHeader()
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        header.setFixedHeight(3 * header.fontMetrics().lineSpacing() + 6)
        for column, width in _WIDTHS.items():
            header.resizeSection(column, width)
        header.setSectionResizeMode(Column.COMPARED, QHeaderView.ResizeMode.Fixed)

    def show_errors(self, runs: Sequence[StoredRun]) -> None:
        """Show the expected error, and the errors that any of the runs has."""
        for column, error in ERRORS.items():
            known = any(math.isfinite(getattr(run, error) or math.nan) for run in runs)
            self.setColumnHidden(column, not known and column != Column.EXPECTED)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give names and values what the errors leave, names first what values do not need; time, iterations and note
        follow them if there is no room."""
        room = self.viewport().width()
        first = sum(_WIDTHS[column] for column in (Column.COMPARED, *ERRORS) if not self.isColumnHidden(column))
        last = sum(_WIDTHS[column] for column in (Column.SECONDS, Column.ITERATIONS, Column.NOTE))
        free = room - first
        room_of_name = max(round(0.4 * free), free - max(self.sizeHintForColumn(Column.VALUES), _LEAST_VALUES))
        name = min(max(min(self.sizeHintForColumn(Column.NAME), room_of_name), _LEAST_NAME), _MOST_NAME)
        values = free - name
        if values - last >= _LEAST_VALUES:
            values -= last
        self.horizontalHeader().resizeSection(Column.NAME, name)
        self.horizontalHeader().resizeSection(Column.VALUES, max(values, _LEAST_VALUES))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        current = self.currentIndex()
        if event.key() == Qt.Key.Key_F2 and current.isValid():
            column = Column.NOTE if current.column() == Column.NOTE else Column.NAME
            self.setCurrentIndex(current.siblingAtColumn(column))
            self.edit(self.currentIndex())
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
