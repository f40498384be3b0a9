"""The kept runs of the present frame: their panel and their commands."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPoint, Qt, Signal
from PySide6.QtWidgets import QMenu

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

# Commands on kept runs.

COMMANDS = (
    Command("show_runs", "&Kept runs", "ph.list-numbers", "Ctrl+Shift+R", "Open the list of this frame's runs"),
    Command(
        "compare_runs",
        "Co&mpare with present",
        "ph.columns",
        "Ctrl+Shift+D",
        "Show the chosen runs, four at most, beside the present result, in views and curves; again to stop",
    ),
    Command(
        "restore_run",
        "Restore &parameters",
        "ph.arrow-u-up-left",
        "",
        "Set the parameters of the chosen run, those of all blocks and those of some; results stay as they are",
    ),
    Command(
        "accept_run",
        "&Accept as the result",
        "ph.check-circle",
        "Ctrl+Shift+A",
        "Let the results of the chosen run be the present ones, with its parameters, where blocks are as they were",
    ),
    Command("rename_run", "Re&name run", "ph.pencil-simple", "", "Give the chosen run another name (F2 in the list)"),
    Command("note_run", "Edit n&ote", "ph.note-pencil", "", "Say something of the chosen run"),
    Command("delete_runs", "&Delete runs", "ph.trash", "", "Keep the chosen runs no longer (Del in the list)"),
    Command(
        "export_runs", "Export runs as CS&V…", "ph.export", "", "Write the list of runs, with all parameters, as CSV"
    ),
    Command("clear_runs", "Clear ru&ns", "ph.backspace", "", "Keep none of the frame's runs"),
)
"""What the window has for them; `RUN_MENU` says in which order."""

RUN_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"


# How good kept runs are: worked out one after the other, off the GUI's thread, while the frame does not run.

Truth = NDArray[np.float32] | None


@dataclass(frozen=True, eq=False)
class _Question:
    """A kept run with its results as they are, and what they are to be compared with."""

    session: Session
    kept: KeptRun
    frame: RGBDFrame
    results: Mapping[int, BlockResult]
    truth: Truth


@dataclass(frozen=True)
class Measures:
    """Root mean squares [m] over the pixels that a run's blocks have filled; NaN where there is none."""

    truth_error: float = math.nan
    expected_error: float = math.nan


class RunMeasurer(QObject):
    """Works out what the list of kept runs lacks of the present frame's runs, the latest first.

    Signals
    -------
    failed(object)
        The exception that kept a run from being measured.
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
        """Whether measures are to come."""
        return self._questions.busy

    def go_on(self) -> None:
        """Measure the next run, if there is one."""
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
        """Stop for good. True if the thread has ended."""
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
    """How good results of a frame's blocks are, by a truth [m] if there is one."""
    completion = compose(frame, results)
    if not completion.filled.any():
        return Measures()
    return Measures(
        truth_error=math.nan if truth is None else judge(completion.depth, truth, completion.filled).rmse,
        expected_error=error_summary(expected_error(completion), completion).rms,
    )


def _answer(question: _Question) -> Measures:
    """Off the GUI's thread."""
    return measure(question.frame, question.results, question.truth)


# The list of kept runs as a file.

_ERRORS = ("rmse_truth [mm]", "rmse_hidden [mm]", "expected_error_rms [mm]")


def write_runs(path: str | os.PathLike[str], rows: Sequence[RunRow]) -> None:
    """Write runs as CSV, one per line: what the list shows, and all common parameters that have an effect.

    Parameters
    ----------
    path : path
    rows : sequence of RunRow
        One at least.

    Raises
    ------
    ExportError
        If the file cannot be written; what was there before is as it was.
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
    """Runs are kept as they end, shown in a table with how good they are, compared, restored and accepted."""

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
        self.measurer.failed.connect(lambda error: desk.notes.report("How good a run is", error))
        for signal in (workspace.session_changed, workspace.kept_runs_changed, workspace.truth_changed):
            signal.connect(self._allow)
            signal.connect(self.measurer.go_on)
        desk.runs.state_changed.connect(self.measurer.go_on)
        self._allow()

    def show(self) -> None:
        """A row per run, if anybody looks."""
        if self.table.isVisible():
            workspace = self.desk.workspace
            self.table.set_rows(run_rows(workspace.session) if workspace.has_session else [])

    def shutdown(self) -> bool:
        """Keep and measure nothing any more. True if no thread is left."""
        return self.keeper.shutdown() and self.measurer.shutdown()

    # commands

    def compare(self) -> None:
        """Compare the chosen runs, and no others, with the present result; none if it is these already."""
        chosen = self._selected()[:MOST_COMPARED]
        compared = self.desk.workspace.session.compared
        same = len(chosen) == len(compared) and all(kept in compared for kept in chosen)
        self.desk.workspace.compare([] if same else chosen)
        if not same:
            first = chosen[0]
            title = title_of(first.name, self.desk.workspace.session, first.run)
            what = f"{title} is" if len(chosen) == 1 else f"{len(chosen)} runs are"
            text = f"{what} compared with the present result: held V shows it."
            self.desk.notes.offer(text, self.desk.actions["compare_two"])

    def restore(self) -> None:
        """Take the parameters of the chosen run."""
        kept = self._chosen()
        if kept is None:
            return
        if self.desk.workspace.restore_run(kept):
            left = len(self.desk.workspace.session.changed_blocks())
            more = f" {left} blocks have no result of them yet: run them (F5)." if left else ""
            self.desk.notes.tell(f"The parameters are those of {kept.name}.{more}")
        else:
            self.desk.notes.tell(f"The parameters are those of {kept.name} already.")

    def accept(self) -> None:
        """Have the results of the chosen run for the present ones, where they fit."""
        kept = self._chosen()
        if kept is None:
            return
        taken = len(self.desk.workspace.accept_run(kept))
        count = len(kept.results)
        if not taken:
            text = f"Nothing of {kept.name} can be accepted: all its blocks have other pixels or known depth since."
        elif taken < count:
            text = f"{kept.name} is the result now; {count - taken} of {count} blocks have other pixels since."
        else:
            text = f"{kept.name} is the result now."
        self.desk.notes.tell(text)

    def delete(self) -> None:
        """Keep the chosen runs no longer."""
        if self.desk.workspace.has_session:
            self.desk.workspace.delete_runs(self.desk.workspace.session, self._selected())

    def clear(self) -> None:
        """Keep none of the frame's runs."""
        session = self.desk.workspace.session
        self.desk.workspace.delete_runs(session, list(session.kept_runs))

    def ask_export(self) -> None:
        """Write the list as a file that the user chooses."""
        name = f"{self.desk.workspace.session.name}-runs.csv"
        path = ask_path(self.desk.window, "Export runs", name, "Table (*.csv)")
        if path:
            self.export(path)

    def export(self, path: str) -> bool:
        """Write the list as CSV; False, with a message, if the file cannot be written."""
        rows = run_rows(self.desk.workspace.session)
        return save(self.desk.notes, path, lambda: write_runs(path, rows))

    # what the table reports

    def _selected(self) -> list[KeptRun]:
        """The chosen runs of the present frame: while nobody looks, the table may have another's."""
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
        actions.allow(none or ("" if chosen else "Choose a run first."), "compare_runs", "delete_runs")
        one = none or ("" if len(chosen) == 1 else "Choose one run first.")
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
