"""Model of the run history: texts, colours, marks and sort keys."""

from __future__ import annotations

import datetime
import html
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QFont, QPalette
from PySide6.QtWidgets import QWidget

from ilf._runtime.formatting import counted, millimetres
from ilf.completion.confidence.expected_error import RMS_MEANING, RMS_NAME
from ilf.data.blocks import Colour
from ilf.data.parameters import PRESETS, Parameters, nearest_preset
from ilf.project.run_history import StoredRun

from ...base import theme
from ...state.document import Document
from ...state.run_history import MAX_COMPARED, parameters_text, title_of
from ...widgets.basics import literal_text
from ...widgets.tables import Index, RowModel

# Rows of the run history, one per run.

COMPARABLE = 0.9
"""Minimum number of filled pixels of a best run, as a share of the largest number of any run."""

ERRORS = ("ground_truth_error", "hold_out_error", "expected_error")
"""Attributes of `StoredRun` with its errors."""


@dataclass(frozen=True)
class RunRow:
    """Row of the list for one run, which identifies the row.

    Attributes
    ----------
    kept : StoredRun
    name, note : str
    title : str
        The name without the values, which have their own column.
    values : str
        Differences to the nearest preset, and what is missing for a complete run of all blocks.
    colour : tuple of int
    compared, present : bool
        Whether the run is compared, and whether its results are the current ones.
    when : datetime
    seconds : float
    iterations : int
    errors : tuple of (float or None)
        The errors in `ERRORS` [m].
    best : tuple of bool
        Which of them are the smallest of all runs.
    """

    kept: StoredRun
    name: str
    title: str
    note: str
    values: str
    colour: Colour
    compared: bool
    present: bool
    when: datetime.datetime
    seconds: float
    iterations: int
    errors: tuple[float | None, ...]
    best: tuple[bool, ...]


def run_rows(document: Document) -> list[RunRow]:
    """Return one row per stored run, the latest first."""
    present = document.valid_results()
    best = [best_of(document.state.runs, error) for error in ERRORS]
    return [
        RunRow(
            kept=kept,
            name=kept.name,
            title=title_of(kept.name, document, kept.run),
            note=kept.note,
            values=" · ".join(text for text in (parameters_text(document, kept.run), missing_parts(kept)) if text),
            colour=kept.colour,
            compared=kept in document.compared,
            present=kept.is_of(present),
            when=kept.when,
            seconds=kept.seconds,
            iterations=kept.iterations,
            errors=tuple(getattr(kept, error) for error in ERRORS),
            best=tuple(kept in those for those in best),
        )
        for kept in reversed(document.state.runs)
    ]


def missing_parts(kept: StoredRun) -> str:
    """Describe what is missing for a complete run with results of its own parameters only; "" for nothing."""
    texts = [] if kept.how == "finished" else [kept.how]
    if missing := kept.block_count - len(kept.results):
        texts.append(f"{missing} of {kept.block_count} blocks without result")
    if outdated := len(kept.outdated):
        texts.append(f"{outdated} of {kept.block_count} blocks with other parameters")
    return ", ".join(texts)


def best_of(runs: Sequence[StoredRun], error: str) -> list[StoredRun]:
    """Return the runs with the smallest error of a kind, several if it is the same in the digits that are shown, of
    those that have filled about as many pixels as any, and for hold-out errors were tested like most; none if fewer
    than two are comparable, or if all of these are equal."""
    most = max((kept.recovered for kept in runs), default=0)
    values = [(kept, getattr(kept, error)) for kept in runs if kept.recovered >= COMPARABLE * most]
    evaluated = [(kept, value) for kept, value in values if value is not None and math.isfinite(value)]
    if error == "hold_out_error" and evaluated:
        tests = [kept.hold_out_test for kept, _ in evaluated]
        usual = max(reversed(tests), key=tests.count)
        evaluated = [(kept, value) for kept, value in evaluated if kept.hold_out_test == usual]
    smallest = millimetres(min((value for _, value in evaluated), default=math.nan))
    best = [kept for kept, value in evaluated if millimetres(value) == smallest]
    return best if len(best) < len(evaluated) else []


SORT_ROLE = Qt.ItemDataRole.UserRole


class Column(IntEnum):
    """Columns of the list, from the left."""

    COMPARED = 0
    COLOUR = 1
    NAME = 2
    VALUES = 3
    SECONDS = 4
    ITERATIONS = 5
    GROUND_TRUTH = 6
    HOLD_OUT = 7
    EXPECTED = 8
    NOTE = 9


EDITABLE = (Column.NAME, Column.NOTE)
ERROR_COLUMNS = (Column.GROUND_TRUTH, Column.HOLD_OUT, Column.EXPECTED)
"""In the order of `ERRORS`."""

_BEST = (
    "Bold with a star: best of the runs that have filled about as many pixels, or equal to it as shown. The panel "
    "Accuracy compares runs on the same pixels."
)
HEADERS = {
    Column.COMPARED: ("", f"Compare: show the run beside the current result (max. {MAX_COMPARED}). Click the tick."),
    Column.COLOUR: ("", "Colour of the run in curves and profiles."),
    Column.NAME: ("Run", "Name of the run; “current” marks the run whose results are shown now. Press F2 to rename."),
    Column.VALUES: ("Values", "The nearest preset, and the differences to it."),
    Column.SECONDS: ("Time [s]", "Duration of the run in seconds."),
    Column.ITERATIONS: ("Iter.", "Iterations of the low-pass filter in all blocks of the run."),
    Column.GROUND_TRUTH: (
        "Truth [mm]",
        f"Root mean square error against the frame's ground truth, over the pixels filled by blocks. {_BEST}",
    ),
    Column.HOLD_OUT: (
        "Hold-out [mm]",
        "Root mean square error on hold-out depth with the run's parameters: hold-out test in the panel Accuracy. "
        f"{_BEST}",
    ),
    Column.EXPECTED: (
        f"{RMS_NAME} [mm]",
        f"{RMS_MEANING}. {_BEST}",
    ),
    Column.NOTE: (
        "Note",
        "Your note on the run. Double-click to edit; runs with a note are not deleted automatically.",
    ),
}
_NUMBERS = (Column.SECONDS, Column.ITERATIONS, *ERROR_COLUMNS)


class RunModel(RowModel[RunRow]):
    """Table model of the run history, the latest run first.

    Signals
    -------
    edited(object, str, str)
        A stored run, "name" or "note", and the text typed by the user.
    ticked(object, bool)
        A stored run, and whether it is to be compared.
    """

    edited = Signal(object, str, str)
    ticked = Signal(object, bool)

    def __init__(self, parent: QWidget) -> None:
        super().__init__(len(Column), parent)
        self._bold = QFont(parent.font())
        self._bold.setBold(True)
        self.set_palette(parent.palette())

    def set_palette(self, palette: QPalette) -> None:
        """Apply the colours of a palette."""
        self._colours = theme.colours(palette)
        self.announce_all()

    def key(self, row: RunRow) -> object:
        return row.kept

    def look(self, row: RunRow, column: int) -> object:
        if column in ERROR_COLUMNS:
            place = ERROR_COLUMNS.index(Column(column))
            return row.errors[place], row.best[place]
        looks: dict[int, object] = {
            Column.COMPARED: row.compared,
            Column.COLOUR: row.colour,
            Column.NAME: (row.name, row.title, row.present, row.seconds),
            Column.VALUES: row.values,
            Column.SECONDS: row.seconds,
            Column.ITERATIONS: row.iterations,
            Column.NOTE: row.note,
        }
        return looks[column]

    def flags(self, index: Index) -> Qt.ItemFlag:
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        if index.column() in EDITABLE:
            return flags | Qt.ItemFlag.ItemIsEditable
        return flags | Qt.ItemFlag.ItemIsUserCheckable if index.column() == Column.COMPARED else flags

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = 0) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = Column(section)
        if role == Qt.ItemDataRole.DisplayRole:
            return HEADERS[column][0]
        if role == Qt.ItemDataRole.ToolTipRole:
            return HEADERS[column][1]
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return HEADERS[column][0] or column.name.capitalize()
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        return None

    def data(self, index: Index, role: int = 0) -> Any:
        row, column = self.rows[index.row()], Column(index.column())
        best = column in ERROR_COLUMNS and row.best[ERROR_COLUMNS.index(column)]
        if role == Qt.ItemDataRole.DisplayRole:
            return _text(row, column)
        if role == Qt.ItemDataRole.EditRole:
            return row.note if column == Column.NOTE else row.name
        if role == SORT_ROLE:
            return _sort_key(row, column)
        if role == Qt.ItemDataRole.CheckStateRole and column == Column.COMPARED:
            return Qt.CheckState.Checked if row.compared else Qt.CheckState.Unchecked
        if role == Qt.ItemDataRole.DecorationRole:
            return QColor(*row.colour) if column == Column.COLOUR else None
        if role == Qt.ItemDataRole.FontRole:
            return self._bold if best or (column == Column.NAME and row.present) else None
        if role == Qt.ItemDataRole.ForegroundRole:
            return self._colours.good if best else None
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(column)
        if role == Qt.ItemDataRole.ToolTipRole:
            return literal_text(_tooltip(row, column))
        if role == Qt.ItemDataRole.AccessibleTextRole and column == Column.COMPARED:
            return f"Compare {row.name}"
        return None

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        row, column = self.rows[index.row()], Column(index.column())
        if role == Qt.ItemDataRole.CheckStateRole:
            self.ticked.emit(row.kept, Qt.CheckState(value) == Qt.CheckState.Checked)
            return True
        text = str(value).strip()
        if column == Column.NOTE and text != row.note:
            self.edited.emit(row.kept, "note", text)
        elif column == Column.NAME and text and text != row.name:
            self.edited.emit(row.kept, "name", text)
        else:
            return False
        return True


def _text(row: RunRow, column: Column) -> str:
    if column in ERROR_COLUMNS:
        place = ERROR_COLUMNS.index(column)
        return f"★ {_millimetres(row.errors[place])}" if row.best[place] else _millimetres(row.errors[place])
    texts = {
        Column.NAME: f"{row.title} · current" if row.present else row.title,
        Column.VALUES: row.values,
        Column.SECONDS: f"{row.seconds:.2f}",
        Column.ITERATIONS: str(row.iterations),
        Column.NOTE: row.note,
    }
    return texts.get(column, "")


def _millimetres(error: float | None) -> str:
    return "" if error is None else millimetres(error)


def _sort_key(row: RunRow, column: Column) -> str | float:
    if column in ERROR_COLUMNS:
        error = row.errors[ERROR_COLUMNS.index(column)]
        return math.inf if error is None or math.isnan(error) else error
    keys: dict[Column, str | float] = {
        Column.COMPARED: not row.compared,
        Column.COLOUR: QColor(*row.colour).hsvHueF(),
        # "Run 10" after "Run 9"
        Column.NAME: re.sub(r"\d+", lambda digits: digits[0].zfill(9), row.name.casefold()),
        Column.VALUES: row.values.casefold(),
        Column.SECONDS: row.seconds,
        Column.ITERATIONS: row.iterations,
        Column.NOTE: row.note.casefold(),
    }
    return keys[column]


def _tooltip(row: RunRow, column: Column) -> str:
    if column == Column.NAME:
        return _run_tooltip(row)
    if column == Column.VALUES:
        return _all_values(row.kept.run.parameters, row.values)
    if column in ERROR_COLUMNS:
        error = row.errors[ERROR_COLUMNS.index(column)]
        if error is None:
            return f"{HEADERS[column][1]} It has not been computed."
        if math.isnan(error):
            return f"{HEADERS[column][1]} It is not defined for this run."
        if column == Column.HOLD_OUT and row.kept.hold_out_test is not None:
            test = row.kept.hold_out_test
            return f"{HEADERS[column][1]} Hold-out: {test.pattern}, seeds {', '.join(map(str, test.seeds))}."
    return row.note if column == Column.NOTE and row.note else HEADERS[column][1]


def _run_tooltip(row: RunRow) -> str:
    kept = row.kept
    lines = [
        row.name,
        f"{row.when:%H:%M:%S}: {len(kept.done)} of {kept.block_count} blocks in {row.seconds:.2f} s, "
        f"{row.iterations} iterations, {kept.how}.",
        f"{counted(kept.recovered, 'pixel')} filled by blocks"
        + (", the rest extrapolated." if kept.extrapolation is not None else "."),
    ]
    return "\n".join([*lines, "Its results are the current ones."] if row.present else lines)


def _all_values(parameters: Parameters, values: str) -> str:
    """Return all parameters that have an effect as rich text; those that differ from the preset are bold."""
    differs = nearest_preset(parameters, PRESETS).differs
    lines = []
    for name, declaration in Parameters.declarations().items():
        if parameters.has_effect(name):
            text = html.escape(f"{declaration.label}: {declaration.to_text(getattr(parameters, name))}")
            lines.append(f"<b>{text}</b>" if name in differs else text)
    return f"<p>{html.escape(values)}</p><p>{'<br>'.join(lines)}</p>"


def _alignment(column: Column) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignRight if column in _NUMBERS else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter
