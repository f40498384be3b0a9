"""The panel *Runs*: the run history of the current frame with its errors, to compare, restore, accept and export."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QToolBar, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted
from ilf.completion.confidence.expected_error import error_summary
from ilf.data.parameters import Parameters, nearest_preset
from ilf.data.results import BlockResult, compose
from ilf.evaluation.evaluation import evaluate
from ilf.io.tables import write_csv
from ilf.project.run_history import StoredRun
from ilf.run.run import Run

from ...base.commands import command
from ...base.needs import Need
from ...state.document import MAX_COMPARED, Document
from ...state.parts import Part
from ...widgets.basics import lay_out
from ...widgets.docks import PanelGroup
from ...widgets.file_choice import ask_path, save
from ...widgets.row_table import ICON_SIZE
from ...work.frame_runs import RunState
from ...work.run_recorder import RunRecorder, title_of
from ..context import Context
from ..panel import Panel
from .table import RunColumn, RunView, values_of

_MENU = "compare_runs accept_run restore_run | rename_run note_run delete_runs | export_runs clear_runs"
_BUTTONS = "compare_runs accept_run restore_run | delete_runs export_runs"


_UNDEFINED = (math.nan, math.nan)


def measure(
    run: Run, results: Mapping[int, BlockResult], ground_truth: NDArray[np.float32] | None
) -> tuple[float, float]:
    """Compute the errors of results of a run's blocks: root mean square [m] over the pixels that they filled, against
    ground truth and as expected; NaN if undefined."""
    completion = compose(run, results)
    if not completion.filled.any():
        return _UNDEFINED
    expected = error_summary(completion).rms
    if ground_truth is None:
        return math.nan, expected
    return evaluate(completion.depth, ground_truth, completion.filled).rmse, expected


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

    def make(self) -> QWidget:
        """Make the table, with its commands above it as icons."""
        actions = self.context.actions
        self.view = RunView()
        widget = QWidget()
        bar = QToolBar()
        bar.setIconSize(QSize(ICON_SIZE, ICON_SIZE))
        actions.fill(bar, _BUTTONS)
        lay_out(QVBoxLayout(widget), bar, self.view, spacing=0, stretched=self.view)
        widget.setFocusProxy(self.view)
        self.view.rows.edited.connect(self._edit)
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self.view, self.delete)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        self.view.selectionModel().selectionChanged.connect(lambda *_: actions.refresh())
        self.view.rows.rowsRemoved.connect(lambda *_: actions.refresh())
        self.view.customContextMenuRequested.connect(self._show_menu)
        return widget

    @command("show_runs", "Run histor&y", icon="ph.list-numbers", keys="Ctrl+Shift+R")
    def _show_runs(self) -> None:
        """Open the list of this frame's runs."""
        self.context.panels.enter(self.title)

    def _why_not_one(self) -> str:
        return "" if len(self.selected()) == 1 else "Select one run first."

    @command("rename_run", "Re&name run", icon="ph.pencil-simple", needs=Need.RUNS, why_off=_why_not_one)
    def _rename(self) -> None:
        """Rename the selected run (F2 in the list)."""
        self._edit_cell(RunColumn.NAME)

    @command("note_run", "Edit n&ote", icon="ph.note-pencil", needs=Need.RUNS, why_off=_why_not_one)
    def _write_note(self) -> None:
        """Edit the note on the selected run."""
        self._edit_cell(RunColumn.VALUES)

    def refresh(self, parts: Part) -> None:
        """Show a row per run, and measure those without errors."""
        document = self.workspace.shown
        self.view.show_runs(document)
        if document is not None and not self.busy and self.context.runs.state in (RunState.IDLE, RunState.PAUSED):
            self._measure(document)

    def _measure(self, document: Document, whole: bool = False, then: Callable[[], object] = lambda: None) -> None:
        """Compute the errors of the latest run without errors, or of the `whole` list, and then do something."""
        lacking = [run for run in reversed(document.state.runs) if None in (run.ground_truth_error, run.expected_error)]
        ground_truth = document.frame.ground_truth
        asked = [(stored, stored.run, stored.results) for stored in (lacking if whole else lacking[:1])]

        def take(found: list[tuple[float, float]]) -> None:
            for (stored, _, results), errors in zip(asked, found, strict=True):
                if stored.results is results and document.frame.ground_truth is ground_truth:
                    stored.ground_truth_error, stored.expected_error = errors
            document.touch(Part.HISTORY, viewing=True)
            then()

        def fail(error: Exception) -> None:
            self.fail(error)
            take([_UNDEFINED] * len(asked))  # reported once

        if asked:
            self.requests.ask(lambda: [measure(run, results, ground_truth) for _, run, results in asked], take, fail)
        else:
            then()

    # commands

    def _why_none_selected(self) -> str:
        return "" if self.selected() else "Select a run first."

    @command(
        "compare_runs",
        "Co&mpare with current",
        icon="ph.columns",
        keys="Ctrl+Shift+D",
        needs=Need.RUNS,
        why_off=_why_none_selected,
    )
    def compare(self) -> None:
        """Show the selected runs (max. four) beside the current result, in views and curves; again to stop.

        They replace those that are compared; the same ones are compared no more.
        """
        document = self.workspace.current
        chosen = self.selected()[:MAX_COMPARED]
        same = len(chosen) == len(document.compared) and all(run in document.compared for run in chosen)
        self._compare([] if same else chosen)

    def _compare(self, runs: list[StoredRun]) -> None:
        """Compare these runs with the current result, and tell how they are seen."""
        document = self.workspace.current
        document.compare_runs(runs)
        if runs:
            title = title_of(runs[0].name, document, runs[0].run)
            what = f"{title} is" if len(runs) == 1 else f"{len(runs)} runs are"
            text = f"{what} compared with the current result: hold V to show it."
            self.notes.offer(text, self.context.actions["compare_two"])

    @command("restore_run", "Restore parameters", icon="ph.arrow-u-up-left", needs=Need.RUNS, why_off=_why_not_one)
    def restore(self) -> None:
        """Set the parameters of the selected run, common and per-block ones; results stay as they are."""
        (stored,) = self.selected()
        if self.workspace.parameters.restore(stored):
            left = len(self.workspace.current.changed_blocks())
            more = f" {counted(left, 'block')} must be run with them (F5)." if left else ""
            self.notes.show_message(f"Parameters of {stored.name} restored.{more}")
        else:
            self.notes.show_message(f"The parameters equal those of {stored.name} already.")

    @command(
        "accept_run",
        "Accept as the res&ult",
        icon="ph.check-circle",
        keys="Ctrl+Shift+A",
        needs=Need.RUNS,
        why_off=_why_not_one,
    )
    def accept(self) -> None:
        """Use the results and parameters of the selected run for all blocks that are unchanged since."""
        (stored,) = self.selected()
        taken, count = len(self.workspace.accept_run(stored)), len(stored.results)
        if not taken:
            text = f"{stored.name} cannot be accepted: the pixels or known depth of all its blocks have changed since."
        elif taken < count:
            text = f"{stored.name} is the result now, except {count - taken} of {count} blocks that have changed since."
        else:
            text = f"{stored.name} is the result now."
        self.notes.show_message(text)

    @command("delete_runs", "&Delete runs", icon="ph.trash", needs=Need.RUNS, why_off=_why_none_selected)
    def delete(self) -> None:
        """Delete the selected runs (Del in the list)."""
        if chosen := self.selected():
            self.workspace.current.delete_runs(chosen)

    @command("clear_runs", "Clear runs", icon="ph.backspace", needs=Need.RUNS)
    def clear(self) -> None:
        """Delete all runs of the frame."""
        document = self.workspace.current
        document.delete_runs(list(document.state.runs))

    @command("export_runs", "Export runs as CS&V…", icon="ph.export", needs=Need.RUNS)
    def ask_export(self) -> None:
        """Write the list of runs, with all parameters, as CSV."""
        name = f"{self.workspace.current.name}-runs.csv"
        if path := ask_path(self.context.window, "Export runs", name, "Table (*.csv)"):
            self.export(path)

    def export(self, path: str) -> None:
        """Write the list of runs, as it is now, as CSV once its errors are computed."""
        document = self.workspace.current
        write = partial(write_runs, path, document, document.state.runs)
        self._measure(document, True, lambda: save(self.notes, path, write))

    # the selection

    def selected(self) -> list[StoredRun]:
        """Return the selected runs of the current frame in table order; a hidden table may show another frame."""
        if not self.made or self.workspace.shown is None:
            return []
        return [stored for stored in self.view.chosen() if stored in self.workspace.shown.state.runs]

    def _edit_cell(self, column: RunColumn) -> None:
        """Edit the name or the note of the selected run in the table."""
        for index in self.view.selectionModel().selectedRows(column)[:1]:
            self.view.setCurrentIndex(index)
            self.view.edit(index)

    def _edit(self, stored: StoredRun, column: int, value: Any) -> None:
        """Take what the user has edited in the table: the history changes, then the row."""
        document = self.workspace.current
        if column == RunColumn.COMPARED:
            others = [one for one in document.compared if one is not stored]
            self._compare([*others, stored] if value else others)
        elif column == RunColumn.VALUES:
            document.change_run(stored, note=value)
        elif value:
            document.change_run(stored, name=value)

    def _show_menu(self, place: QPoint) -> None:
        menu = self.context.actions.menu("", self.view, _MENU)
        menu.exec(self.view.viewport().mapToGlobal(place))
        menu.deleteLater()


# The list as a file.


def write_runs(path: str | os.PathLike[str], document: Document, runs: Sequence[StoredRun]) -> None:
    """Write some runs of a frame as CSV, one per line, at least one: the columns of the table, and all common
    parameters that have an effect.

    Raises
    ------
    ExportError
        If the file cannot be written; an existing file is not changed.
    """
    lines = [_line(document, stored) for stored in reversed(runs)]
    write_csv(path, [lines[0], *(line.values() for line in lines)])


def _line(document: Document, stored: StoredRun) -> dict[str, object]:
    parameters = stored.run.parameters
    values = parameters.to_dict()
    return {
        "number": stored.number,
        "name": stored.name,
        "note": stored.note,
        "when": stored.when.isoformat(timespec="seconds"),
        "how": stored.how,
        "time [s]": f"{stored.seconds:.3f}" if stored.seconds else "",
        "iterations": stored.iterations,
        "blocks_run": len(stored.done),
        "blocks_with_result": len(stored.results),
        "blocks": stored.block_count,
        "filled [px]": stored.recovered,
        "rmse_truth [mm]": _in_millimetres(stored.ground_truth_error),
        "rmse_hold_out [mm]": _in_millimetres(stored.hold_out_error),
        "expected_error_rms [mm]": _in_millimetres(stored.expected_error),
        "preset": nearest_preset(parameters).preset,
        "values": values_of(document, stored),
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.has_effect(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }


def _in_millimetres(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"
