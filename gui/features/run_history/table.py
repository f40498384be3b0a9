"""The table of runs: the columns that tell runs apart first."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from enum import IntEnum

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView

from ilf._runtime.formatting import UNKNOWN, counted, millimetres, natural
from ilf.completion.confidence.expected_error import RMS_MEANING, RMS_NAME
from ilf.data.parameters import PRESETS, Parameters, nearest_preset
from ilf.project.run_history import StoredRun

from ...state.document import MAX_COMPARED, Document
from ...widgets.row_table import Heading, RowTable, TableCell
from ...work.run_recorder import parameters_text, title_of


class RunColumn(IntEnum):
    """Columns of the table, from the left."""

    COMPARED = 0
    NAME = 1
    GROUND_TRUTH = 2
    HOLD_OUT = 3
    EXPECTED = 4
    VALUES = 5
    """With the note on the run, which is edited."""
    SECONDS = 6
    ITERATIONS = 7


ERRORS = {
    RunColumn.GROUND_TRUTH: "ground_truth_error",
    RunColumn.HOLD_OUT: "hold_out_error",
    RunColumn.EXPECTED: "expected_error",
}
"""Columns of errors, and the attributes of `StoredRun` with them."""

_NAME, _MOST_NAME = 86, 220
"""Width that names have before values, and the greatest [px]."""

_COMPARABLE = 0.9
"""Minimum number of filled pixels of a best run, as a share of the largest number of any run."""
_BEST = (
    "Bold with a star: best of the finished runs that have filled about as many pixels, or equal to it as shown. The "
    "panel Accuracy compares runs on the same pixels."
)
_HEADINGS: dict[int, Heading] = {
    RunColumn.COMPARED: Heading(
        "", f"Compare: show the run beside the current result (max. {MAX_COMPARED}). Click the tick.", kind="tick"
    ),
    RunColumn.NAME: Heading(
        "Run",
        "Name of the run, in its colour in curves and profiles; a dot marks the run whose results are shown "
        "now. Press F2 to rename.",
        kind="edited",
    ),
    RunColumn.GROUND_TRUTH: Heading(
        "Truth [mm]",
        f"Root mean square error against the frame's ground truth, over the pixels filled by blocks. {_BEST}",
        54,
        "number",
    ),
    RunColumn.HOLD_OUT: Heading(
        "Hold-out [mm]",
        "Root mean square error on hold-out depth with the run's parameters: hold-out test in the panel Accuracy. "
        f"{_BEST}",
        62,
        "number",
    ),
    RunColumn.EXPECTED: Heading("Expected [mm]", f"{RMS_NAME}: {RMS_MEANING}. {_BEST}", 68, "number"),
    RunColumn.VALUES: Heading(
        "Note · values",
        "Your note on the run, the nearest preset, and the differences to it. Double-click to edit the note; runs with "
        "one are not deleted automatically.",
        kind="edited",
    ),
    RunColumn.SECONDS: Heading("Time [s]", "Duration of the run in seconds.", 60, "number"),
    RunColumn.ITERATIONS: Heading("Iter.", "Iterations of the low-pass filter in all blocks of the run.", 52, "number"),
}


def values_of(document: Document, run: StoredRun) -> str:
    """Describe how a run differs from the nearest preset, and what is missing for a complete run of all blocks with
    its own parameters."""
    texts = [parameters_text(document, run.run), "" if run.how == "finished" else run.how]
    missing = run.block_count - len(run.results)
    for count, what in ((missing, "without result"), (len(run.outdated), "with other parameters")):
        texts.append(f"{count} of {run.block_count} blocks {what}" if count else "")
    first, *others = texts
    return " · ".join(filter(None, (first, ", ".join(filter(None, others)))))


def _cells(document: Document, run: StoredRun, present: bool, best: frozenset[RunColumn]) -> dict[int, TableCell]:
    """Return what the table shows of a run; `best` are the errors that no other run has smaller."""
    title, noted = title_of(run.name, document, run.run), " · ".join(filter(None, (run.note, values_of(document, run))))
    seconds = f"{run.seconds:.2f}" if run.seconds else UNKNOWN
    about = (
        f"{run.name}\n{run.when:%H:%M:%S}: {len(run.done)} of {run.block_count} blocks"
        f"{f' in {seconds} s' if run.seconds else ''}, {run.iterations} iterations, {run.how}.\n"
        f"{counted(run.recovered, 'pixel')} filled by blocks"
        f"{'' if run.extrapolation is None else ', the rest extrapolated'}."
        f"{' Its results are the current ones.' if present else ''}"
    )
    compared = run in document.compared
    return {
        RunColumn.COMPARED: TableCell(key=not compared, ticked=compared, said=f"Compare {run.name}"),
        RunColumn.NAME: TableCell(
            f"● {title}" if present else title,
            natural(run.name),
            about,
            run.colour,
            bold=present,
            edited=run.name,
            said=f"● {title}, current" if present else "",
        ),
        **{column: _error_cell(run, column, column in best) for column in ERRORS},
        RunColumn.VALUES: TableCell(
            noted, noted.casefold(), _all_values(run.run.parameters, noted), edited=run.note, said=noted
        ),
        RunColumn.SECONDS: TableCell(seconds, run.seconds),
        RunColumn.ITERATIONS: TableCell(str(run.iterations), run.iterations),
    }


def _error_cell(run: StoredRun, column: RunColumn, best: bool) -> TableCell:
    error: float | None = getattr(run, ERRORS[column])
    hint = _HEADINGS[column].hint
    if error is None:
        return TableCell("", math.inf, f"{hint} It has not been computed.")
    if math.isnan(error):
        return TableCell(millimetres(error), math.inf, f"{hint} It is not defined for this run.")
    if column == RunColumn.HOLD_OUT and run.hold_out_test is not None:
        test = run.hold_out_test
        hint = f"{hint} Hold-out: {test.pattern}, seeds {', '.join(map(str, test.seeds))}."
    text = millimetres(error)
    return TableCell(f"★ {text}", error, hint, tone="good", bold=True) if best else TableCell(text, error, hint)


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
    those that have finished and filled about as many pixels as any, and for hold-out errors, which are of parameters,
    were tested like most; none if fewer than two are comparable, or if all of these are equal."""
    runs = [run for run in runs if run.how == "finished" or error == "hold_out_error"]
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


class RunView(RowTable):
    """The table, the latest run first; it shares its width among the columns, and shows the columns of errors that any
    run has."""

    def __init__(self) -> None:
        super().__init__("Run history", _HEADINGS)
        self.hint = "Every run is listed here with its parameters and errors."
        self.setEditTriggers(QAbstractItemView.EditTrigger.DoubleClicked)
        header = self.horizontalHeader()
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap)
        header.setFixedHeight(2 * header.fontMetrics().lineSpacing() + 6)
        header.setMinimumSectionSize(1)
        header.setSectionResizeMode(RunColumn.VALUES, QHeaderView.ResizeMode.Stretch)

    def show_runs(self, document: Document | None) -> None:
        """Show the runs of a frame, and the columns of the errors that any of them has."""
        runs = [] if document is None else list(reversed(document.state.runs))
        best = {column: best_of(runs[::-1], error) for column, error in ERRORS.items()}
        rows = {}
        if document is not None:
            present = document.valid_results()
            for run in runs:
                smallest = frozenset(column for column, those in best.items() if run in those)
                rows[run] = _cells(document, run, run.is_of(present), smallest)
        self.rows.show_rows(rows)
        for column, error in ERRORS.items():
            known = any(math.isfinite(getattr(run, error) or math.nan) for run in runs)
            self.setColumnHidden(column, not known and column != RunColumn.EXPECTED)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        """Give names the width of their texts, or half of what the errors leave, and values the rest; show times and
        iterations, which the hint of the name tells, too, if values leave room for them."""
        free = self.viewport().width() - sum(map(self.columnWidth, (RunColumn.COMPARED, *ERRORS)))
        wanted = self.sizeHintForColumn(RunColumn.VALUES)
        most = min(max(free // 2, free - wanted, _NAME), _MOST_NAME, free - 1)
        heading = self.horizontalHeader().sectionSizeHint(RunColumn.NAME)
        name = min(max(heading, self.sizeHintForColumn(RunColumn.NAME)), most)
        self.setColumnWidth(RunColumn.NAME, name)
        left = free - name - wanted
        for column in (RunColumn.SECONDS, RunColumn.ITERATIONS):
            left -= _HEADINGS[column].width
            self.setColumnHidden(column, left < 0)
