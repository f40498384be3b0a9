"""Evaluation against ground truth, and errors as rows of the panel's tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor, QGuiApplication, QIcon, QKeyEvent, QKeySequence, QPaintEvent, QPixmap
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.completion.confidence.expected_error import expected_error
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.data.results import Completion
from ilf.evaluation.evaluation import Evaluated, Evaluation, PixelErrors, evaluate_blocks, evaluate_completion
from ilf.evaluation.ground_truth import shared_pixels
from ilf.evaluation.ties import Ties

from ...base import theme
from ...state.document import Document
from ...widgets.basics import Themed, literal_text, paint_hint
from .hold_out_tests import CandidateResult, HoldOutOutcome, find_best

# Texts of errors: millimetres and shares, for the tables of the panel.

RMSE = ("RMSE", "Root mean square error in millimetres: large errors count most")
MAE = ("MAE", "Mean absolute error in millimetres")
MEDIAN = ("Med.", "Median of the absolute errors in millimetres: half of the pixels are below")
WITHIN = (
    "Within",
    "Share of the filled pixels whose error is within their expected error; about 68 % is expected",
)
PIXELS = ("Pixels", "Number of evaluated pixels")


def errors(evaluation: Evaluation) -> tuple[str, str, str]:
    """RMSE, MAE and median."""
    return millimetres(evaluation.rmse), millimetres(evaluation.mae), millimetres(evaluation.median)


def within(evaluation: Evaluation) -> str:
    """The share within the expected error."""
    known = evaluation.within is not None and math.isfinite(evaluation.within)
    return f"{evaluation.within:.0%}" if known else UNKNOWN


def thousands(count: int) -> str:
    """Short text of a number of pixels.

    Examples
    --------
    >>> thousands(121573), thousands(430), thousands(0)
    ('122k', '430', '–')
    """
    return f"{count / 1000:.0f}k" if count >= 10_000 else str(count) if count else UNKNOWN


# Evaluation of results against ground truth, in a worker thread: for the frame, blocks and a rectangle.


@dataclass(frozen=True, eq=False)
class EvaluatedResult:
    """A result to evaluate: the current one, or that of a run.

    Attributes
    ----------
    name : str
    completion : Completion
    frame : RGBDFrame
        Frame of the result.
    colour : (int, int, int) or None
        Colour of the run.
    """

    name: str
    completion: Completion
    frame: RGBDFrame
    colour: tuple[int, int, int] | None = None


@dataclass(frozen=True, eq=False)
class EvaluationRequest:
    """Request for an evaluation.

    Attributes
    ----------
    session : Session
    ground_truth : ndarray of float32, shape (H, W)
        [m], NaN = unknown.
    entries : tuple
        The first is the current result.
    labels : ndarray of int32, shape (H, W)
        The current label map.
    areas : mapping of str to (tuple of int or Box or None)
        Name of a part of the frame -> labels of blocks, a rectangle, or None for all of it.
    every : bool
        Whether known pixels also count.
    with_expected : bool
        Whether to compute the share within the expected error, which takes longer.
    """

    document: Document
    ground_truth: NDArray[np.float32]
    entries: tuple[EvaluatedResult, ...]
    labels: NDArray[np.int32]
    areas: Mapping[str, tuple[int, ...] | Box | None]
    every: bool
    with_expected: bool


@dataclass(frozen=True, eq=False)
class EvaluationResult:
    """Result of an evaluation.

    Attributes
    ----------
    areas : mapping of str to tuple of Evaluation
        Part of the frame -> an Evaluation for each entry, over the pixels that all of them have filled.
    best : mapping of str to (Ties or None)
        Part of the frame -> the entries with the smallest error.
    blocks : mapping of int to Judgement
        Label -> Evaluation of all pixels that the current result has filled.
    """

    areas: Mapping[str, tuple[Evaluation, ...]] = field(default_factory=dict)
    best: Mapping[str, Ties | None] = field(default_factory=dict)
    blocks: Mapping[int, Evaluation] = field(default_factory=dict)


class Evaluator:
    """Evaluates requests, one at a time; caches the expected error of each completion as long as that exists."""

    def __init__(self) -> None:
        self._expected: WeakKeyDictionary[Completion, NDArray[np.float32]] = WeakKeyDictionary()

    def __call__(self, question: EvaluationRequest) -> EvaluationResult:
        """Evaluate; called in a worker thread."""
        present = question.entries[0]
        areas, best = {}, {}
        shared = shared_pixels([entry.completion for entry in question.entries], every=question.every)
        for name, area in question.areas.items():
            where = shared & _inside(area, question.labels)
            areas[name] = tuple(self._evaluated(question, entry, where) for entry in question.entries)
            best[name] = find_best([_pixel_errors(question, entry, where) for entry in question.entries])
        return EvaluationResult(areas, best, evaluate_blocks(present.frame, present.completion, question.labels))

    def _evaluated(self, question: EvaluationRequest, entry: EvaluatedResult, where: NDArray[np.bool_]) -> Evaluation:
        expected = self._expected_error(entry) if question.with_expected else self._expected.get(entry.completion)
        frame = (
            entry.frame
            if entry.frame.ground_truth is question.ground_truth
            else entry.frame.with_ground_truth(question.ground_truth)
        )
        return evaluate_completion(frame, entry.completion, where, every=question.every, expected=expected)

    def _expected_error(self, entry: EvaluatedResult) -> NDArray[np.float32]:
        found = self._expected.get(entry.completion)
        if found is None:
            found = self._expected[entry.completion] = expected_error(entry.completion)
        return found


def _pixel_errors(question: EvaluationRequest, entry: EvaluatedResult, where: NDArray[np.bool_]) -> Evaluated:
    places = np.flatnonzero(where & np.isfinite(question.ground_truth))
    depth, ground_truth = entry.completion.depth.ravel()[places], question.ground_truth.ravel()[places]
    return Evaluated(question.labels, (PixelErrors(places, depth, ground_truth, np.full_like(depth, np.nan)),))


def _inside(area: tuple[int, ...] | Box | None, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    if area is None:
        return np.ones(labels.shape, bool)
    if not isinstance(area[0], slice):
        return np.isin(labels, area)
    inside = np.zeros(labels.shape, bool)
    inside[area] = True
    return inside


# A small table of numbers: rows in groups, with the best marked.

_SWATCH = 10
_ROW_PAD = 6
_CELL_PAD = 13
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class Row:
    """One row of the table.

    Attributes
    ----------
    name : str
    cells : tuple of str
        One for each column but the first; empty for the heading of a group.
    hint : str
        Tooltip.
    colour : (int, int, int) or None
        Colour of its run.
    is_best : bool
        Whether it is the best row of its group, or equal to it.
    """

    name: str
    cells: tuple[str, ...] = ()
    hint: str = ""
    colour: tuple[int, int, int] | None = None
    is_best: bool = False


class NumberTable(Themed, QTreeWidget):
    """Table of numbers with group headings; Ctrl+C copies tab-separated text."""

    def __init__(self, name: str, columns: Sequence[tuple[str, str]], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._empty = ""
        self._rows: tuple[Row, ...] = ()
        self.setAccessibleName(name)
        self.setColumnCount(1 + len(columns))
        self.setHeaderLabels(["", *(title for title, _ in columns)])
        for number, (_, hint) in enumerate(columns, 1):
            self.headerItem().setToolTip(number, hint)
            self.headerItem().setTextAlignment(number, _RIGHT)
        header = self.header()
        header.setStretchLastSection(False)
        header.setMinimumSectionSize(36)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        for number, (title, _) in enumerate(columns, 1):
            widest = max(self.fontMetrics().horizontalAdvance(text) for text in (title, "1000"))
            header.setSectionResizeMode(number, QHeaderView.ResizeMode.Interactive)
            header.resizeSection(number, widest + _CELL_PAD)
        self.setRootIsDecorated(False)
        self.setIndentation(0)
        self.setUniformRowHeights(True)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setFrameShape(QTreeWidget.Shape.NoFrame)

    @property
    def rows(self) -> tuple[Row, ...]:
        """Rows shown."""
        return self._rows

    def set_rows(self, rows: Iterable[Row], empty: str = "") -> None:
        """Show other rows; `empty` is the text shown without rows."""
        wanted = tuple(rows)
        if (wanted, empty) != (self._rows, self._empty):
            self._rows, self._empty = wanted, empty
            self._fill()

    def text(self) -> str:
        """The selected rows, or all, as tab-separated text."""
        chosen = [self.indexOfTopLevelItem(item) for item in self.selectedItems()]
        rows = [self._rows[number] for number in sorted(chosen)] or list(self._rows)
        head = [self.headerItem().text(number) for number in range(self.columnCount())]
        return "\n".join("\t".join(cells) for cells in [head, *((row.name, *row.cells) for row in rows)])

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(self.text())
        else:
            super().keyPressEvent(event)

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if not self._rows and self._empty:
            paint_hint(self, self._empty)

    def _take_theme(self) -> None:
        if hasattr(self, "_rows"):
            self._fill()

    def _fill(self) -> None:
        colours = theme.colours(self.palette())
        self.clear()
        for row in self._rows:
            item = QTreeWidgetItem([row.name, *row.cells])
            item.setSizeHint(0, QSize(0, self.fontMetrics().height() + _ROW_PAD))
            for number in range(self.columnCount()):
                item.setToolTip(number, literal_text(row.hint or row.name))
                if number:
                    item.setTextAlignment(number, _RIGHT)
                if row.is_best or not row.cells:
                    font = item.font(number)
                    font.setBold(True)
                    item.setFont(number, font)
                if row.is_best:
                    item.setForeground(number, colours.good)
            if row.colour is not None:
                item.setIcon(0, _swatch(row.colour))
            if not row.cells:
                item.setForeground(0, colours.muted)
                item.setFlags(Qt.ItemFlag.ItemIsEnabled)
            self.addTopLevelItem(item)
            if not row.cells:
                item.setFirstColumnSpanned(True)


def _swatch(colour: tuple[int, int, int]) -> QIcon:
    pixels = QPixmap(_SWATCH, _SWATCH)
    pixels.fill(QColor(*colour))
    return QIcon(pixels)


def ground_truth_rows(answer: EvaluationResult, entries: Sequence[EvaluatedResult]) -> list[Row]:
    """Rows for the parts of the frame, each with a row per result; for a single result, a row per part."""
    rows = []
    for name, evaluated in answer.areas.items():
        if len(entries) == 1:
            rows.append(_row(name, evaluated[0], _Rank(), None, name))
            continue
        rows.append(Row(name))
        best = answer.best.get(name)
        for number, (entry, one) in enumerate(zip(entries, evaluated, strict=True)):
            rows.append(_row(entry.name, one, _rank(best, number, len(entries)), entry.colour, f"{name}, {entry.name}"))
    return rows


def hold_out_rows(outcome: HoldOutOutcome, label: int) -> list[Row]:
    """Rows of the tested candidates, over all blocks or over one."""
    evaluated = [one.blocks.get(label, Evaluation()) if label else one.whole for one in outcome.tested]
    best = outcome.best.get(label)
    return [
        _hold_out_row(tested, one, _rank(best, number, len(evaluated)))
        for number, (tested, one) in enumerate(zip(outcome.tested, evaluated, strict=True))
    ]


class _Rank(NamedTuple):
    """Whether a row is marked as one of the best, and a sentence on it; "" for the others."""

    is_best: bool = False
    text: str = ""


def _rank(best: Ties | None, number: int, count: int) -> _Rank:
    """Rank a row of several: if all are equal, none is marked."""
    if best is None or count < 2 or number not in best.equal:
        return _Rank()
    if not best:
        return _Rank(True, " Smallest RMSE of all.")
    others = "All" if len(best.equal) == count else f"{len(best.equal)} of them, with the smallest RMSE,"
    return _Rank(len(best.equal) < count, f" {others} are equal within {millimetres(best.within)} mm.")


def _row(name: str, evaluated: Evaluation, rank: _Rank, colour: tuple[int, int, int] | None, what: str) -> Row:
    if not evaluated.pixels:
        hint = f"{what}: no pixel has both a result and ground truth."
    else:
        hint = f"{what}: {evaluated.pixels:,} pixels, mean error {1000 * evaluated.bias:+.2f} mm."
        hint += rank.text
    return Row(name, (*errors(evaluated), within(evaluated)), hint, colour, rank.is_best)


def _hold_out_row(tested: CandidateResult, evaluated: Evaluation, rank: _Rank) -> Row:
    came_back = f"{tested.coverage:.1%} of the held-out depth was filled."
    hint = f"{tested.candidate.name}: {evaluated.pixels:,} pixels. {came_back}"
    hint += rank.text
    if evaluated.within is not None:
        hint += f" {evaluated.within:.0%} of the errors are within the expected error."
    colour = None if tested.candidate.kept is None else tested.candidate.kept.colour
    count = thousands(evaluated.pixels)
    return Row(tested.candidate.name, (*errors(evaluated), count), hint, colour, rank.is_best)
