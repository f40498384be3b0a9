"""Run history of the current frame: panel and commands."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPoint, Signal
from PySide6.QtWidgets import QMenu

from ilf._runtime.formatting import counted
from ilf.completion.confidence.expected_error import error_summary, expected_error
from ilf.data.parameters import Parameters, nearest_preset
from ilf.data.results import BlockResult, compose
from ilf.evaluation.evaluation import evaluate
from ilf.io.tables import write_csv
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ...base.commands import Command
from ...state.document import Document
from ...state.run_history import MAX_COMPARED, title_of
from ...state.workspace import Workspace
from ...widgets.docks import PanelGroup
from ...widgets.file_choice import ask_path, save
from ...work.frame_runs import RunState
from ...work.latest_request import LatestRequest
from ...work.run_recorder import RunRecorder
from ...work.runs import RunController
from ..context import Context, Feature
from .model import Column, RunRow, run_rows
from .table import RunTable

RUN_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"


# Errors of stored runs: computed one after the other in a worker thread while the frame is not running.

GroundTruth = NDArray[np.float32] | None


@dataclass(frozen=True, eq=False)
class _Request:
    """Request: a stored run with its current results, and the ground truth to compare them with."""

    document: Document
    kept: StoredRun
    run: Run
    results: Mapping[int, BlockResult]
    ground_truth: GroundTruth


@dataclass(frozen=True)
class RunErrors:
    """Root mean square errors [m] over the pixels filled by a run's blocks; NaN if undefined."""

    ground_truth_error: float = math.nan
    expected_error: float = math.nan


class RunErrorCalculator(QObject):
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
        self._questions = LatestRequest[_Request, RunErrors](_compute, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether measures are pending."""
        return self._questions.busy

    def go_on(self) -> None:
        """Measure the next run without errors, if there is one."""
        if not self._workspace.has_current or self._questions.busy:
            return
        document = self._workspace.current
        if self._runs.state not in (RunState.IDLE, RunState.PAUSED):
            return
        lacking = (
            kept for kept in reversed(document.state.runs) if None in (kept.ground_truth_error, kept.expected_error)
        )
        kept = next(lacking, None)
        if kept is not None:
            self._questions.ask(_Request(document, kept, kept.run, kept.results, document.frame.ground_truth))

    def _take(self, question: _Request, measures: RunErrors) -> None:
        kept, document = question.kept, question.document
        if kept.results is question.results and document.frame.ground_truth is question.ground_truth:
            kept.ground_truth_error, kept.expected_error = measures.ground_truth_error, measures.expected_error
            document.note_run_measured()
        self.go_on()

    def _fail(self, question: _Request, error: Exception) -> None:
        self._take(question, RunErrors())
        self.failed.emit(error)


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


def _compute(question: _Request) -> RunErrors:
    """Measure a run; called in a worker thread."""
    return measure(question.run, question.results, question.ground_truth)


# The run history as a file.

_ERRORS = ("rmse_truth [mm]", "rmse_hold_out [mm]", "expected_error_rms [mm]")


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
        "preset": nearest_preset(parameters).preset,
        "values": row.values,
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.has_effect(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }


def _millimetres(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"


_TITLE = "Runs"


class RunHistoryFeature(Feature):
    """Stores finished runs, shows them in a table with their errors, and compares, restores and accepts them."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, actions = context.workspace, context.actions
        actions.add(self._commands())
        self.keeper = RunRecorder(workspace, context.runs, self)
        self.measurer = RunErrorCalculator(workspace, context.runs, self)
        names = ["compare_runs", "accept_run", "restore_run"]
        self.table = RunTable(
            [
                *((actions[name], True) for name in names),
                None,
                *((actions[name], False) for name in ("delete_runs", "export_runs")),
            ]
        )
        context.panels.add(_TITLE, self.table, PanelGroup.SETTINGS, "ph.list-numbers")
        results = workspace.frames.session_changed, workspace.runs.history_changed, workspace.runs.compared_changed
        context.refresh.add(
            "runs",
            self.show,
            (*results, workspace.runs.results_changed, workspace.blocks.infos_changed, self.table.shown),
            (workspace.runs.results_added,),
        )
        self.table.edited.connect(self._edit)
        self.table.ticked.connect(self._tick)
        self.table.deleteRequested.connect(self.delete)
        self.table.contextMenuRequested.connect(self._show_menu)
        self.table.selectionChanged.connect(actions.refresh)
        self.keeper.message.connect(context.notes.show_message)
        self.measurer.failed.connect(lambda error: context.notes.report("Errors of a run", error))
        for signal in (
            workspace.frames.session_changed,
            workspace.runs.history_changed,
            workspace.blocks.ground_truth_changed,
        ):
            signal.connect(self.measurer.go_on)
        context.runs.state_changed.connect(self.measurer.go_on)

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "show_runs",
                "Run histor&y",
                "Open the list of this frame's runs",
                icon="ph.list-numbers",
                keys="Ctrl+Shift+R",
                handler=lambda: self.context.panels.reveal(_TITLE),
            ),
            Command(
                "compare_runs",
                "Co&mpare with current",
                "Show the selected runs (max. four) beside the current result, in views and curves; again to stop",
                icon="ph.columns",
                keys="Ctrl+Shift+D",
                handler=self.compare,
                why_off=self._why_none_selected,
            ),
            Command(
                "restore_run",
                "Restore &parameters",
                "Set the parameters of the selected run, common and per-block ones; results stay as they are",
                icon="ph.arrow-u-up-left",
                handler=self.restore,
                why_off=self._why_not_one,
            ),
            Command(
                "accept_run",
                "&Accept as the result",
                "Use the results and parameters of the selected run for all blocks that are unchanged since",
                icon="ph.check-circle",
                keys="Ctrl+Shift+A",
                handler=self.accept,
                why_off=self._why_not_one,
            ),
            Command(
                "rename_run",
                "Re&name run",
                "Rename the selected run (F2 in the list)",
                icon="ph.pencil-simple",
                handler=lambda: self.table.edit(Column.NAME),
                why_off=self._why_not_one,
            ),
            Command(
                "note_run",
                "Edit n&ote",
                "Edit the note on the selected run",
                icon="ph.note-pencil",
                handler=lambda: self.table.edit(Column.NOTE),
                why_off=self._why_not_one,
            ),
            Command(
                "delete_runs",
                "&Delete runs",
                "Delete the selected runs (Del in the list)",
                icon="ph.trash",
                handler=self.delete,
                why_off=self._why_none_selected,
            ),
            Command(
                "export_runs",
                "Export runs as CS&V…",
                "Write the list of runs, with all parameters, as CSV",
                icon="ph.export",
                handler=self.ask_export,
                why_off=self._why_none,
            ),
            Command(
                "clear_runs",
                "Clear ru&ns",
                "Delete all runs of the frame",
                icon="ph.backspace",
                handler=self.clear,
                why_off=self._why_none,
            ),
        )

    def show(self) -> None:
        """Show a row per run if the table is visible."""
        if self.table.isVisible():
            workspace = self.context.workspace
            self.table.set_rows(run_rows(workspace.current) if workspace.has_current else [])

    def shutdown(self) -> bool:
        """Stop permanently. True if no thread is left."""
        return self.keeper.shutdown()

    # commands

    def compare(self) -> None:
        """Compare exactly the selected runs with the current result; stop if they are compared already."""
        chosen = self._selected()[:MAX_COMPARED]
        compared = self.context.workspace.current.compared
        same = len(chosen) == len(compared) and all(kept in compared for kept in chosen)
        self.context.workspace.current.compare_runs([] if same else chosen)
        if not same:
            first = chosen[0]
            title = title_of(first.name, self.context.workspace.current, first.run)
            what = f"{title} is" if len(chosen) == 1 else f"{len(chosen)} runs are"
            text = f"{what} compared with the current result: hold V to show it."
            self.context.notes.offer(text, self.context.actions["compare_two"])

    def restore(self) -> None:
        """Set the parameters of the selected run."""
        kept = self._chosen()
        if kept is None:
            return
        if self.context.workspace.parameters.restore(kept):
            left = len(self.context.workspace.current.changed_blocks())
            more = f" {counted(left, 'block')} must be run with them (F5)." if left else ""
            self.context.notes.show_message(f"Parameters of {kept.name} restored.{more}")
        else:
            self.context.notes.show_message(f"The parameters equal those of {kept.name} already.")

    def accept(self) -> None:
        """Use the results of the selected run as the current ones for unchanged blocks."""
        kept = self._chosen()
        if kept is None:
            return
        taken = len(self.context.workspace.accept_run(kept))
        count = len(kept.results)
        if not taken:
            text = f"{kept.name} cannot be accepted: the pixels or known depth of all its blocks have changed since."
        elif taken < count:
            text = f"{kept.name} is the result now, except {count - taken} of {count} blocks that have changed since."
        else:
            text = f"{kept.name} is the result now."
        self.context.notes.show_message(text)

    def delete(self) -> None:
        """Delete the selected runs."""
        if self.context.workspace.has_current:
            self.context.workspace.current.delete_runs(self._selected())

    def clear(self) -> None:
        """Delete all runs of the frame."""
        document = self.context.workspace.current
        document.delete_runs(list(document.state.runs))

    def ask_export(self) -> None:
        """Write the list to a file that the user chooses."""
        name = f"{self.context.workspace.current.name}-runs.csv"
        path = ask_path(self.context.window, "Export runs", name, "Table (*.csv)")
        if path:
            self.export(path)

    def export(self, path: str) -> bool:
        """Write the list as CSV; return False, with a message, if the file cannot be written."""
        rows = run_rows(self.context.workspace.current)
        return save(self.context.notes, path, lambda: write_runs(path, rows))

    # signals of the table

    def _selected(self) -> list[StoredRun]:
        """Return the selected runs of the current frame; a hidden table may contain those of another frame."""
        workspace = self.context.workspace
        there = workspace.current.state.runs if workspace.has_current else []
        return [kept for kept in self.table.selected() if kept in there]

    def _chosen(self) -> StoredRun | None:
        chosen = self._selected()
        return chosen[0] if len(chosen) == 1 else None

    def _edit(self, kept: StoredRun, what: str, text: str) -> None:
        self.context.workspace.current.change_run(kept, **{what: text})

    def _tick(self, kept: StoredRun, on: bool) -> None:
        others = [one for one in self.context.workspace.current.compared if one is not kept]
        self.context.workspace.current.compare_runs([*others, kept] if on else others)

    def _why_none(self) -> str:
        workspace = self.context.workspace
        there = workspace.has_current and workspace.current.state.runs
        return "" if there else "There are no runs yet."

    def _why_none_selected(self) -> str:
        return self._why_none() or ("" if self._selected() else "Select a run first.")

    def _why_not_one(self) -> str:
        return self._why_none() or ("" if len(self._selected()) == 1 else "Select one run first.")

    def _show_menu(self, place: QPoint) -> None:
        menu = QMenu(self.table)
        menu.setToolTipsVisible(True)
        for name in RUN_MENU.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(self.context.actions[name])
        menu.exec(place)
        menu.deleteLater()
