"""Run history of the current frame: panel and commands."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPoint, Qt, Signal
from PySide6.QtWidgets import QMenu

from ilf._runtime.formatting import counted
from ilf.completion.confidence.expected_error import error_summary, expected_error
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters, likeness
from ilf.data.results import BlockResult, compose
from ilf.evaluation.evaluation import judge
from ilf.io.tables import write_csv
from ilf.project.run_history import KeptRun

from ...base.commands import Command
from ...state.run_history import MOST_COMPARED
from ...state.run_names import title_of
from ...state.session import Session
from ...state.workspace import Workspace
from ...work.frame_runs import RunState
from ...work.keeping import RunKeeper
from ...work.latest_question import LatestQuestion
from ...work.runs import RunController
from ..context import Desk, Part
from ..documents.file_dialogs import ask_path, save
from .model import Column, RunRow, run_rows
from .table import RunTable

# Commands on the run history.

COMMANDS = (
    Command("show_runs", "Run histor&y", "ph.list-numbers", "Ctrl+Shift+R", "Open the list of this frame's runs"),
    Command(
        "compare_runs",
        "Co&mpare with current",
        "ph.columns",
        "Ctrl+Shift+D",
        "Show the selected runs (max. four) beside the current result, in views and curves; again to stop",
    ),
    Command(
        "restore_run",
        "Restore &parameters",
        "ph.arrow-u-up-left",
        "",
        "Set the parameters of the selected run, common and per-block ones; results stay as they are",
    ),
    Command(
        "accept_run",
        "&Accept as the result",
        "ph.check-circle",
        "Ctrl+Shift+A",
        "Use the results and parameters of the selected run for all blocks that are unchanged since",
    ),
    Command("rename_run", "Re&name run", "ph.pencil-simple", "", "Rename the selected run (F2 in the list)"),
    Command("note_run", "Edit n&ote", "ph.note-pencil", "", "Edit the note on the selected run"),
    Command("delete_runs", "&Delete runs", "ph.trash", "", "Delete the selected runs (Del in the list)"),
    Command(
        "export_runs", "Export runs as CS&V…", "ph.export", "", "Write the list of runs, with all parameters, as CSV"
    ),
    Command("clear_runs", "Clear ru&ns", "ph.backspace", "", "Delete all runs of the frame"),
)

RUN_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"


# Errors of stored runs: computed one after the other in a worker thread while the frame is not running.

Truth = NDArray[np.float32] | None


@dataclass(frozen=True, eq=False)
class _Question:
    """Request: a stored run with its current results, and the ground truth to compare them with."""

    session: Session
    kept: KeptRun
    frame: RGBDFrame
    results: Mapping[int, BlockResult]
    truth: Truth


@dataclass(frozen=True)
class Measures:
    """Root mean square errors [m] over the pixels filled by a run's blocks; NaN if undefined."""

    truth_error: float = math.nan
    expected_error: float = math.nan


class RunMeasurer(QObject):
    """Computes the missing errors of the current frame's runs, the latest run first.

    Signals
    -------
    failed(object)
        The exception raised while a run was measured.
    """

    failed = Signal(object)

    def __init__(self, workspace: Workspace, runs: RunController, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._runs = runs
        self._questions = LatestQuestion[_Question, Measures](_answer, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether measures are pending."""
        return self._questions.busy

    def go_on(self) -> None:
        """Measure the next run without errors, if there is one."""
        if not self._workspace.has_session or self._questions.busy:
            return
        session = self._workspace.session
        if self._runs.state not in (RunState.IDLE, RunState.PAUSED):
            return
        lacking = (kept for kept in reversed(session.kept_runs) if None in (kept.truth_error, kept.expected_error))
        kept = next(lacking, None)
        if kept is not None:
            self._questions.ask(_Question(session, kept, kept.run.frame, kept.results, session.frame.truth))

    def shutdown(self) -> bool:
        """Stop permanently. True if the thread has ended."""
        return self._questions.shutdown()

    def _take(self, question: _Question, measures: Measures) -> None:
        kept, session = question.kept, question.session
        if kept.results is question.results and session.frame.truth is question.truth:
            kept.truth_error, kept.expected_error = measures.truth_error, measures.expected_error
            self._workspace.note_measured(session)
        self.go_on()

    def _fail(self, question: _Question, error: Exception) -> None:
        self._take(question, Measures())
        self.failed.emit(error)


def measure(frame: RGBDFrame, results: Mapping[int, BlockResult], truth: Truth) -> Measures:
    """Compute the errors of results of a frame's blocks, with ground truth [m] if there is one."""
    completion = compose(frame, results)
    if not completion.filled.any():
        return Measures()
    return Measures(
        truth_error=math.nan if truth is None else judge(completion.depth, truth, completion.filled).rmse,
        expected_error=error_summary(expected_error(completion), completion).rms,
    )


def _answer(question: _Question) -> Measures:
    """Measure a run; called in a worker thread."""
    return measure(question.frame, question.results, question.truth)


# The run history as a file.

_ERRORS = ("rmse_truth [mm]", "rmse_hidden [mm]", "expected_error_rms [mm]")


def write_runs(path: str | os.PathLike[str], rows: Sequence[RunRow]) -> None:
    """Write runs as CSV, one per line: the columns of the list, and all common parameters that have an effect.

    Parameters
    ----------
    path : path
    rows : sequence of RunRow
        At least one.

    Raises
    ------
    ExportError
        If the file cannot be written; an existing file is not changed.
    """
    lines = [_line(row) for row in rows]
    write_csv(path, [lines[0], *(line.values() for line in lines)])


def _line(row: RunRow) -> dict[str, object]:
    kept, parameters = row.kept, row.kept.run.parameters
    values = parameters.to_dict()
    return {
        "number": kept.number,
        "name": row.name,
        "note": row.note,
        "when": row.when.isoformat(timespec="seconds"),
        "how": kept.how,
        "time [s]": f"{row.seconds:.3f}",
        "iterations": row.iterations,
        "blocks_run": len(kept.done),
        "blocks_with_result": len(kept.results),
        "blocks": kept.block_count,
        "filled [px]": kept.recovered,
        **{name: _millimetres(error) for name, error in zip(_ERRORS, row.errors, strict=True)},
        "preset": likeness(parameters).preset,
        "values": row.values,
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.matters(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }


def _millimetres(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"


_TITLE = "Runs"


class KeptRunsPart(Part):
    """Stores finished runs, shows them in a table with their errors, and compares, restores and accepts them."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        workspace, actions = desk.workspace, desk.actions
        actions.add(COMMANDS)
        self.keeper = RunKeeper(workspace, desk.runs, self)
        self.measurer = RunMeasurer(workspace, desk.runs, self)
        names = ["compare_runs", "accept_run", "restore_run"]
        self.table = RunTable(
            [
                *((actions[name], True) for name in names),
                None,
                *((actions[name], False) for name in ("delete_runs", "export_runs")),
            ]
        )
        desk.panels.add(_TITLE, self.table, Qt.DockWidgetArea.BottomDockWidgetArea, "ph.list-numbers", 1.7)
        results = workspace.session_changed, workspace.kept_runs_changed, workspace.compared_changed
        desk.refresh.add(
            "runs",
            self.show,
            (*results, workspace.results_changed, workspace.infos_changed, self.table.shown),
            (workspace.results_added,),
        )
        handlers: dict[str, Callable[[], object]] = {
            "show_runs": lambda: desk.panels.reveal(_TITLE),
            "compare_runs": self.compare,
            "restore_run": self.restore,
            "accept_run": self.accept,
            "rename_run": lambda: self.table.edit(Column.NAME),
            "note_run": lambda: self.table.edit(Column.NOTE),
            "delete_runs": self.delete,
            "export_runs": self.ask_export,
            "clear_runs": self.clear,
        }
        for name, handler in handlers.items():
            actions[name].triggered.connect(lambda _=False, handler=handler: handler())
        self.table.edited.connect(self._edit)
        self.table.ticked.connect(self._tick)
        self.table.deleteWished.connect(self.delete)
        self.table.contextMenuRequested.connect(self._show_menu)
        self.table.selectionChanged.connect(self._allow)
        self.keeper.message.connect(desk.notes.tell)
        self.measurer.failed.connect(lambda error: desk.notes.report("Errors of a run", error))
        for signal in (workspace.session_changed, workspace.kept_runs_changed, workspace.truth_changed):
            signal.connect(self._allow)
            signal.connect(self.measurer.go_on)
        desk.runs.state_changed.connect(self.measurer.go_on)
        self._allow()

    def show(self) -> None:
        """Show a row per run if the table is visible."""
        if self.table.isVisible():
            workspace = self.desk.workspace
            self.table.set_rows(run_rows(workspace.session) if workspace.has_session else [])

    def shutdown(self) -> bool:
        """Stop permanently. True if no thread is left."""
        return self.keeper.shutdown() and self.measurer.shutdown()

    # commands

    def compare(self) -> None:
        """Compare exactly the selected runs with the current result; stop if they are compared already."""
        chosen = self._selected()[:MOST_COMPARED]
        compared = self.desk.workspace.session.compared
        same = len(chosen) == len(compared) and all(kept in compared for kept in chosen)
        self.desk.workspace.compare([] if same else chosen)
        if not same:
            first = chosen[0]
            title = title_of(first.name, self.desk.workspace.session, first.run)
            what = f"{title} is" if len(chosen) == 1 else f"{len(chosen)} runs are"
            text = f"{what} compared with the current result: hold V to show it."
            self.desk.notes.offer(text, self.desk.actions["compare_two"])

    def restore(self) -> None:
        """Set the parameters of the selected run."""
        kept = self._chosen()
        if kept is None:
            return
        if self.desk.workspace.restore_run(kept):
            left = len(self.desk.workspace.session.changed_blocks())
            more = f" {counted(left, 'block')} must be run with them (F5)." if left else ""
            self.desk.notes.tell(f"Parameters of {kept.name} restored.{more}")
        else:
            self.desk.notes.tell(f"The parameters equal those of {kept.name} already.")

    def accept(self) -> None:
        """Use the results of the selected run as the current ones for unchanged blocks."""
        kept = self._chosen()
        if kept is None:
            return
        taken = len(self.desk.workspace.accept_run(kept))
        count = len(kept.results)
        if not taken:
            text = f"{kept.name} cannot be accepted: the pixels or known depth of all its blocks have changed since."
        elif taken < count:
            text = f"{kept.name} is the result now, except {count - taken} of {count} blocks that have changed since."
        else:
            text = f"{kept.name} is the result now."
        self.desk.notes.tell(text)

    def delete(self) -> None:
        """Delete the selected runs."""
        if self.desk.workspace.has_session:
            self.desk.workspace.delete_runs(self.desk.workspace.session, self._selected())

    def clear(self) -> None:
        """Delete all runs of the frame."""
        session = self.desk.workspace.session
        self.desk.workspace.delete_runs(session, list(session.kept_runs))

    def ask_export(self) -> None:
        """Write the list to a file that the user chooses."""
        name = f"{self.desk.workspace.session.name}-runs.csv"
        path = ask_path(self.desk.window, "Export runs", name, "Table (*.csv)")
        if path:
            self.export(path)

    def export(self, path: str) -> bool:
        """Write the list as CSV; return False, with a message, if the file cannot be written."""
        rows = run_rows(self.desk.workspace.session)
        return save(self.desk.notes, path, lambda: write_runs(path, rows))

    # signals of the table

    def _selected(self) -> list[KeptRun]:
        """Return the selected runs of the current frame; a hidden table may contain those of another frame."""
        workspace = self.desk.workspace
        there = workspace.session.kept_runs if workspace.has_session else []
        return [kept for kept in self.table.selected() if kept in there]

    def _chosen(self) -> KeptRun | None:
        chosen = self._selected()
        return chosen[0] if len(chosen) == 1 else None

    def _edit(self, kept: KeptRun, what: str, text: str) -> None:
        self.desk.workspace.change_run(self.desk.workspace.session, kept, **{what: text})

    def _tick(self, kept: KeptRun, on: bool) -> None:
        others = [one for one in self.desk.workspace.session.compared if one is not kept]
        self.desk.workspace.compare([*others, kept] if on else others)

    def _allow(self) -> None:
        workspace, actions = self.desk.workspace, self.desk.actions
        there = bool(workspace.has_session and workspace.session.kept_runs)
        chosen = self._selected()
        none = "" if there else "There are no runs yet."
        actions.allow(none or ("" if chosen else "Select a run first."), "compare_runs", "delete_runs")
        one = none or ("" if len(chosen) == 1 else "Select one run first.")
        actions.allow(one, "restore_run", "accept_run", "rename_run", "note_run")
        actions.allow(none, "export_runs", "clear_runs")

    def _show_menu(self, place: QPoint) -> None:
        menu = QMenu(self.table)
        menu.setToolTipsVisible(True)
        for name in RUN_MENU.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(self.desk.actions[name])
        menu.exec(place)
        menu.deleteLater()
