"""The panel *Runs*: the run history of the current frame with its errors, to compare, restore, accept and export."""

from __future__ import annotations

import html
import math
import os
import re
from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QPoint, QSize, QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QColor, QFont, QKeyEvent, QPaintEvent, QResizeEvent, QStandardItem, QStandardItemModel
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QMenu,
    QTableView,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted, millimetres
from ilf.completion.confidence.expected_error import RMS_MEANING, RMS_NAME, error_summary, expected_error
from ilf.data.parameters import PRESETS, Parameters, nearest_preset
from ilf.data.results import BlockResult, compose
from ilf.evaluation.evaluation import evaluate
from ilf.io.tables import write_csv
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ..base import theme
from ..base.commands import Command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..state.run_history import MAX_COMPARED, parameters_text, title_of
from ..widgets.basics import literal_text, paint_hint
from ..widgets.docks import PanelGroup
from ..widgets.file_choice import ask_path, save
from ..widgets.tables import ICON_SIZE, RowDelegate, set_up_table
from ..work.frame_runs import RunState
from ..work.run_recorder import RunRecorder
from .context import Context
from .panel import Panel

_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"
_BUTTONS = "compare_runs accept_run restore_run | delete_runs export_runs"

# Errors of runs.

_COMPARABLE = 0.9
"""Minimum number of filled pixels of a best run, as a share of the largest number of any run."""

GroundTruth = NDArray[np.float32] | None


class RunErrors(NamedTuple):
    """Root mean square errors [m] over the pixels filled by a run's blocks; NaN if undefined."""

    ground_truth_error: float = math.nan
    expected_error: float = math.nan


def measure(run: Run, results: Mapping[int, BlockResult], ground_truth: GroundTruth) -> RunErrors:
    """Compute the errors of results of a run's blocks, with ground truth [m] if there is one."""
    completion = compose(run, results)
    if not completion.filled.any():
        return RunErrors()
    return RunErrors(
        ground_truth_error=math.nan
        if ground_truth is None
        else evaluate(completion.depth, ground_truth, completion.filled).rmse,
        expected_error=error_summary(expected_error(completion), completion).rms,
    )


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


# The table: the columns that tell runs apart first.


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
    about = (
        f"{run.name}\n{run.when:%H:%M:%S}: {len(run.done)} of {run.block_count} blocks in {run.seconds:.2f} s, "
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
        Column.SECONDS: _Cell(f"{run.seconds:.2f}", run.seconds, _HEADERS[Column.SECONDS][1]),
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
        self._shown: list[dict[Column, _Cell]] = []
        self._parent = parent
        for column, (text, hint) in _HEADERS.items():
            header = QStandardItem(text)
            header.setToolTip(hint)
            header.setAccessibleText(text or "Compare")
            self.setHorizontalHeaderItem(column, header)

    def show_runs(self, document: Document | None) -> None:
        """Show the runs of a frame; only cells that have changed are drawn, so that editors stay open."""
        runs = [] if document is None else list(reversed(document.state.runs))
        for row in reversed(range(len(self.runs))):
            if self.runs[row] not in runs:
                del self.runs[row], self._shown[row]
                self.removeRow(row)
        present = {} if document is None else document.valid_results()
        best = {column: best_of(runs[::-1], error) for column, error in ERRORS.items()}
        for row, run in enumerate(runs):
            if row == len(self.runs) or self.runs[row] is not run:
                self.runs.insert(row, run)
                self._shown.insert(row, {})
                self.insertRow(row, [_item(run, column) for column in Column])
            if document is not None:
                smallest = frozenset(column for column, those in best.items() if run in those)
                self._draw(row, _cells(document, run, run.is_of(present), smallest))

    def _draw(self, row: int, cells: dict[Column, _Cell]) -> None:
        for column, cell in cells.items():
            if self._shown[row].get(column) == cell:
                continue
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
        self._shown[row] = cells

    def data(self, index: QModelIndex | QPersistentModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        column = index.column()
        if role == Qt.ItemDataRole.EditRole and column == Column.NAME:
            return self.runs[index.row()].name
        if role == Qt.ItemDataRole.ForegroundRole and column in ERRORS:
            best = self._shown[index.row()][Column(column)].strong
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


class _View(QTableView):
    """The table; it shares its width among the columns, and shows the columns of errors that any run has."""

    delete_requested = Signal()

    def __init__(self, model: RunModel) -> None:
        super().__init__()
        proxy = QSortFilterProxyModel(self)
        proxy.setSourceModel(model)
        proxy.setSortRole(_SORT_ROLE)
        self.setModel(proxy)
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
        """Give names and values what the errors leave; time, iterations and note follow them if there is no room."""
        room = self.viewport().width()
        first = sum(_WIDTHS[column] for column in (Column.COMPARED, *ERRORS) if not self.isColumnHidden(column))
        last = sum(_WIDTHS[column] for column in (Column.SECONDS, Column.ITERATIONS, Column.NOTE))
        free = room - first
        name = min(max(round(0.4 * free), _LEAST_NAME), _MOST_NAME)
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


class _Request(NamedTuple):
    """A stored run with its current results, and the ground truth to compare them with."""

    document: Document
    stored: StoredRun
    run: Run
    results: Mapping[int, BlockResult]
    ground_truth: GroundTruth


class RunsPanel(Panel):
    """Stores finished runs, and shows them in a table with their errors, which are computed one run after the other
    while the panel is visible and the frame is not running."""

    title, icon, group = "Runs", "ph.list-numbers", PanelGroup.SETTINGS
    parts = Part.FRAME | Part.HISTORY | Part.COMPARED | Part.RESULTS | Part.INFOS | Part.GROUND_TRUTH | Part.RUNNING
    deferred = Part.SOME_RESULTS
    what = "computation of a run's errors"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.keeper = RunRecorder(context.workspace, context.runs, self)
        self.keeper.message.connect(context.notes.show_message)
        self._export: tuple[Document, str] | None = None
        """A list that is to be written to this file when all of its errors are computed."""

    def make(self) -> QWidget:
        """Make the table, with its commands above it as icons."""
        actions = self.context.actions
        actions.add(self._commands())
        self.model = RunModel(self.context.window)
        self.view = _View(self.model)
        widget = QWidget()
        row = QHBoxLayout()
        row.setContentsMargins(4, 2, 4, 2)
        row.setSpacing(2)
        for name in _BUTTONS.split():
            if name == "|":
                row.addSpacing(10)
                continue
            button = QToolButton(autoRaise=True)
            button.setDefaultAction(actions[name])
            button.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
            row.addWidget(button)
        row.addStretch()
        layout = QVBoxLayout(widget)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(row)
        layout.addWidget(self.view, 1)
        widget.setFocusProxy(self.view)
        self.model.edited.connect(self._edit)
        self.view.delete_requested.connect(self.delete)
        self.view.selectionModel().selectionChanged.connect(lambda *_: actions.refresh())
        self.model.rowsRemoved.connect(lambda *_: actions.refresh())
        self.view.customContextMenuRequested.connect(self._show_menu)
        return widget

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "show_runs",
                "Run histor&y",
                "Open the list of this frame's runs",
                icon="ph.list-numbers",
                keys="Ctrl+Shift+R",
                handler=self.reveal,
            ),
            Command(
                "compare_runs",
                "Co&mpare with current",
                "Show the selected runs (max. four) beside the current result, in views and curves; again to stop",
                icon="ph.columns",
                keys="Ctrl+Shift+D",
                handler=self.compare,
                needs=Need.FRAME,
                why_off=self._why_none_selected,
            ),
            Command(
                "restore_run",
                "Restore &parameters",
                "Set the parameters of the selected run, common and per-block ones; results stay as they are",
                icon="ph.arrow-u-up-left",
                handler=self.restore,
                needs=Need.FRAME,
                why_off=self._why_not_one,
            ),
            Command(
                "accept_run",
                "&Accept as the result",
                "Use the results and parameters of the selected run for all blocks that are unchanged since",
                icon="ph.check-circle",
                keys="Ctrl+Shift+A",
                handler=self.accept,
                needs=Need.FRAME,
                why_off=self._why_not_one,
            ),
            Command(
                "rename_run",
                "Re&name run",
                "Rename the selected run (F2 in the list)",
                icon="ph.pencil-simple",
                handler=lambda: self.edit_cell(Column.NAME),
                needs=Need.FRAME,
                why_off=self._why_not_one,
            ),
            Command(
                "note_run",
                "Edit n&ote",
                "Edit the note on the selected run",
                icon="ph.note-pencil",
                handler=lambda: self.edit_cell(Column.NOTE),
                needs=Need.FRAME,
                why_off=self._why_not_one,
            ),
            Command(
                "delete_runs",
                "&Delete runs",
                "Delete the selected runs (Del in the list)",
                icon="ph.trash",
                handler=self.delete,
                needs=Need.FRAME,
                why_off=self._why_none_selected,
            ),
            Command(
                "export_runs",
                "Export runs as CS&V…",
                "Write the list of runs, with all parameters, as CSV",
                icon="ph.export",
                handler=self.ask_export,
                needs=Need.FRAME,
                why_off=self._why_none,
            ),
            Command(
                "clear_runs",
                "Clear ru&ns",
                "Delete all runs of the frame",
                icon="ph.backspace",
                handler=self.clear,
                needs=Need.FRAME,
                why_off=self._why_none,
            ),
        )

    def refresh(self, parts: Part) -> None:
        """Show a row per run, and measure those without errors."""
        document = self.context.workspace.current if self.context.workspace.has_current else None
        self.model.show_runs(document)
        self.view.show_errors(self.model.runs)
        if document is not None:
            self._measure(document)

    def _measure(self, document: Document) -> bool:
        """Measure the latest run without errors, unless the frame is running; return whether one is being measured."""
        ground_truth = document.frame.ground_truth
        lacking = (run for run in reversed(document.state.runs) if None in (run.ground_truth_error, run.expected_error))
        stored = next(lacking, None)
        if stored is not None and not self.busy and self.context.runs.state in (RunState.IDLE, RunState.PAUSED):
            self.ask(_Request(document, stored, stored.run, stored.results, ground_truth))
        return stored is not None and self.busy

    def compute(self, request: _Request) -> RunErrors:
        """Measure a run."""
        return measure(request.run, request.results, request.ground_truth)

    def take(self, request: _Request, answer: RunErrors) -> None:
        """Store the errors of a run, and go on to the next one; write the list if it waits for them."""
        stored, document = request.stored, request.document
        if stored.results is request.results and document.frame.ground_truth is request.ground_truth:
            stored.ground_truth_error, stored.expected_error = answer
            document.note_run_measured()
        if self._export is not None:
            self.export(self._export[1], self._export[0])

    def fail(self, request: _Request, error: Exception) -> None:
        """Report the error once: the run has no errors."""
        self.take(request, RunErrors())
        super().fail(request, error)

    def shutdown(self) -> bool:
        """Stop permanently. True if no thread is left."""
        self.keeper.shutdown()
        return super().shutdown()

    # commands

    def compare(self) -> None:
        """Compare exactly the selected runs with the current result; stop if they are compared already."""
        document = self.context.workspace.current
        chosen = self.selected()[:MAX_COMPARED]
        same = len(chosen) == len(document.compared) and all(run in document.compared for run in chosen)
        self.context.workspace.current.compare_runs([] if same else chosen)
        if not same:
            title = title_of(chosen[0].name, document, chosen[0].run)
            what = f"{title} is" if len(chosen) == 1 else f"{len(chosen)} runs are"
            text = f"{what} compared with the current result: hold V to show it."
            self.context.notes.offer(text, self.context.actions["compare_two"])

    def restore(self) -> None:
        """Set the parameters of the selected run."""
        (stored,) = self.selected()
        if self.context.workspace.parameters.restore(stored):
            left = len(self.context.workspace.current.changed_blocks())
            more = f" {counted(left, 'block')} must be run with them (F5)." if left else ""
            self.context.notes.show_message(f"Parameters of {stored.name} restored.{more}")
        else:
            self.context.notes.show_message(f"The parameters equal those of {stored.name} already.")

    def accept(self) -> None:
        """Use the results of the selected run as the current ones for unchanged blocks."""
        (stored,) = self.selected()
        taken, count = len(self.context.workspace.accept_run(stored)), len(stored.results)
        if not taken:
            text = f"{stored.name} cannot be accepted: the pixels or known depth of all its blocks have changed since."
        elif taken < count:
            text = f"{stored.name} is the result now, except {count - taken} of {count} blocks that have changed since."
        else:
            text = f"{stored.name} is the result now."
        self.context.notes.show_message(text)

    def delete(self) -> None:
        """Delete the selected runs."""
        if chosen := self.selected():
            self.context.workspace.current.delete_runs(chosen)

    def clear(self) -> None:
        """Delete all runs of the frame."""
        document = self.context.workspace.current
        document.delete_runs(list(document.state.runs))

    def ask_export(self) -> None:
        """Write the list to a file that the user chooses."""
        name = f"{self.context.workspace.current.name}-runs.csv"
        if path := ask_path(self.context.window, "Export runs", name, "Table (*.csv)"):
            self.export(path)

    def export(self, path: str, document: Document | None = None) -> None:
        """Write the list of a frame, the current one if none is given, as CSV once its errors are computed."""
        document = document or self.context.workspace.current
        self._export = (document, path) if self._measure(document) else None
        if self._export is None:
            save(self.context.notes, path, lambda: write_runs(path, document))

    # the selection

    def select(self, stored: StoredRun) -> None:
        """Select only this run, and scroll to it."""
        index = self._proxy.mapFromSource(self.model.index(self.model.runs.index(stored), Column.NAME))
        self.view.selectRow(index.row())
        self.view.scrollTo(index)

    def selected(self) -> list[StoredRun]:
        """Return the selected runs of the current frame in table order; a hidden table may show another frame."""
        workspace = self.context.workspace
        there = workspace.current.state.runs if workspace.has_current else ()
        rows = sorted(self.view.selectionModel().selectedRows(), key=QModelIndex.row)
        chosen = [self.model.runs[self._proxy.mapToSource(index).row()] for index in rows]
        return [stored for stored in chosen if stored in there]

    def edit_cell(self, column: Column) -> None:
        """Edit the name or the note of the selected run in the table."""
        for index in self.view.selectionModel().selectedRows(column)[:1]:
            self.view.setCurrentIndex(index)
            self.view.edit(index)

    @property
    def _proxy(self) -> QSortFilterProxyModel:
        proxy = self.view.model()
        assert isinstance(proxy, QSortFilterProxyModel)
        return proxy

    def _edit(self, stored: StoredRun, what: str, value: Any) -> None:
        workspace = self.context.workspace
        if what == "compared":
            others = [one for one in workspace.current.compared if one is not stored]
            workspace.current.compare_runs([*others, stored] if value else others)
        else:
            workspace.current.change_run(stored, **{what: value})

    def _why_none(self) -> str:
        return "" if self.context.workspace.current.state.runs else "There are no runs yet."

    def _why_none_selected(self) -> str:
        return self._why_none() or ("" if self.selected() else "Select a run first.")

    def _why_not_one(self) -> str:
        return self._why_none() or ("" if len(self.selected()) == 1 else "Select one run first.")

    def _show_menu(self, place: QPoint) -> None:
        menu = QMenu(self.view)
        menu.setToolTipsVisible(True)
        for name in _MENU.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(self.context.actions[name])
        menu.exec(self.view.viewport().mapToGlobal(place))
        menu.deleteLater()


# The run history as a file.


def write_runs(path: str | os.PathLike[str], document: Document) -> None:
    """Write the runs of a frame as CSV, one per line, at least one: the columns of the table, and all common
    parameters that have an effect.

    Raises
    ------
    ExportError
        If the file cannot be written; an existing file is not changed.
    """
    lines = [_line(document, stored) for stored in reversed(document.state.runs)]
    write_csv(path, [lines[0], *(line.values() for line in lines)])


def _line(document: Document, stored: StoredRun) -> dict[str, object]:
    parameters = stored.run.parameters
    values = parameters.to_dict()
    names = "rmse_truth [mm]", "rmse_hold_out [mm]", "expected_error_rms [mm]"
    errors: list[float | None] = [getattr(stored, error) for error in ERRORS.values()]
    return {
        "number": stored.number,
        "name": stored.name,
        "note": stored.note,
        "when": stored.when.isoformat(timespec="seconds"),
        "how": stored.how,
        "time [s]": f"{stored.seconds:.3f}",
        "iterations": stored.iterations,
        "blocks_run": len(stored.done),
        "blocks_with_result": len(stored.results),
        "blocks": stored.block_count,
        "filled [px]": stored.recovered,
        **{
            name: "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"
            for name, error in zip(names, errors, strict=True)
        },
        "preset": nearest_preset(parameters).preset,
        "values": values_of(document, stored),
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.has_effect(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }
