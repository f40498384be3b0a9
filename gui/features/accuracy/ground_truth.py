"""Errors against ground truth, computed in a worker thread, for the panel and for the table of blocks."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QComboBox, QGridLayout, QWidget

from ilf._runtime.named_places import note_opened
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.drawing.colours import sample
from ilf.errors import InputError
from ilf.io.frame_additions import with_ground_truth_file
from ilf.sources.naming import DEPTH_FILE_SUFFIXES

from ...state.document import Document
from ...widgets.basics import PlainLabel
from ...widgets.file_choice import choose_file
from ...work.latest_request import LatestRequest
from ..context import Context
from ..documents.file_dialogs import PreviewDialog
from .panel import NO_FRAME, AccuracyPanel
from .rows import EvaluatedResult, EvaluationRequest, EvaluationResult, Evaluator, ground_truth_rows

# The dialog that loads ground truth: file, units and preview.

_FOLDER_KEY = "truth/folder"
_AUTOMATIC = "Automatic (those of the depth, if both are whole numbers)"
_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "1 (metres)", "256 (KITTI)")
_NOTHING_SELECTED = "Select the true depth of the same pixels: a 16-bit or float image, or NPY."


class GroundTruthSource(NamedTuple):
    """A file with the ground truth of a frame, and its units per metre if given."""

    frame: RGBDFrame
    path: str
    units: float | None = None


def frame_with(source: GroundTruthSource) -> RGBDFrame:
    """Return the frame with the ground truth of the file; called in a worker thread."""
    frame = with_ground_truth_file(source.frame, source.path, source.units)
    note_opened(source.path)
    return frame


class GroundTruthDialog(PreviewDialog[GroundTruthSource, RGBDFrame]):
    """Dialog to select a ground truth file, with a preview.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestRequest
        Reads a `GroundTruthSource`.
    """

    def __init__(
        self, frame: RGBDFrame, questions: LatestRequest[GroundTruthSource, RGBDFrame], parent: QWidget | None = None
    ) -> None:
        placeholder = "True depth: PNG, TIFF, PGM or NPY"
        title = f"Load Ground Truth for {frame.name}"
        super().__init__(title, placeholder, _NOTHING_SELECTED, "Ground truth", questions, parent)
        self._frame = frame
        self.path.setToolTip("The file with the true depth")
        self.load_button.setToolTip("Evaluate the frame's results against this ground truth")
        self.units = QComboBox(editable=True)
        self.units.addItems([_AUTOMATIC, *_UNITS])
        self.units.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.units.setCompleter(None)  # type: ignore[arg-type]  # it would swallow Enter
        self.units.setToolTip(
            "File units per metre. Automatic: those of the frame's depth if both are whole numbers; otherwise 1000 for "
            "whole numbers and 1 for floating-point depth."
        )
        self.units.editTextChanged.connect(self.schedule)
        self.setMinimumWidth(600)
        self.ask(self._form())

    def source(self, path: str) -> GroundTruthSource:
        units = _units(self.units.currentText())
        return GroundTruthSource(self._frame, str(Path(path).expanduser().absolute()), units)

    def show_found(self, found: RGBDFrame) -> None:
        if found.ground_truth is not None:
            self.preview.show_depth(found.ground_truth)
        left_out = found.notes[len(self._frame.notes) :]
        self.message.show_message(" ".join((described(found), *left_out)), "warning" if left_out else "good")

    def _form(self) -> QGridLayout:
        self.file_button.setToolTip("Select the file with the true depth")
        grid = QGridLayout()
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(8)
        grid.setColumnStretch(1, 1)
        for row, (text, field) in enumerate((("Ground &truth", self.path), ("&Units per metre", self.units))):
            label = PlainLabel(text)
            label.setBuddy(field)
            grid.addWidget(label, row, 0)
            grid.addWidget(field, row, 1, 1, 1 if field is self.path else 2)
        grid.addWidget(self.file_button, 0, 2)
        return grid

    def browse(self) -> None:
        patterns = " ".join(f"*{suffix}" for suffix in DEPTH_FILE_SUFFIXES)
        self.choose(choose_file(self, "Select ground truth", _FOLDER_KEY, f"Depth ({patterns});;All files (*)"))


def described(frame: RGBDFrame) -> str:
    """Describe the coverage and deviation of a frame's ground truth, from a sample of its pixels."""
    if frame.ground_truth is None:
        return "There is no ground truth."
    ground_truth, depth = sample(frame.ground_truth), sample(frame.depth)
    known, missing = np.isfinite(ground_truth), np.isnan(depth)
    share = known[missing].mean() if missing.any() else known.mean()
    text = f"Known at {share:.0%} of the pixels{' without depth' if missing.any() else ''}"
    both = known & ~missing
    if not both.any():
        return f"{text}."
    off = float(np.median(np.abs(ground_truth[both] - depth[both])))
    return f"{text}; median deviation from the known depth: {1000 * off:.1f} mm."


def _units(text: str) -> float | None:
    """Units per metre from the text of the field; None for automatic."""
    if text.strip() in ("", _AUTOMATIC):
        return None
    try:
        units = float(text.split("(")[0])
    except ValueError:
        units = 0.0
    if not 0 < units < float("inf"):
        raise InputError(f"Units per metre must be a number above 0, such as 1000, not {text!r:.30}.")
    return units


_NO_GROUND_TRUTH = "No ground truth: load it, or run a hold-out test."
_NO_RESULT = "No result to evaluate yet: run the filter."
_EVALUATING = "Evaluating…"


class GroundTruthPresenter(QObject):
    """Presenter of the ground truth page.

    Signals
    -------
    evaluated()
        The errors of the blocks changed.
    """

    evaluated = Signal()

    def __init__(self, context: Context, panel: AccuracyPanel) -> None:
        super().__init__(panel)
        self._context = context
        self._panel = panel
        self._questions = LatestRequest[EvaluationRequest, EvaluationResult](Evaluator(), self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: context.notes.report("Evaluation against ground truth", error))
        self._answered: Document | None = None
        self._shown_frame: RGBDFrame | None = None
        """The frame whose ground truth source is shown."""
        self.blocks: dict[int, float] = {}
        """Label -> RMSE [m] of the current results."""

    @property
    def busy(self) -> bool:
        """Whether an evaluation is in progress."""
        return self._questions.busy

    def show(self) -> None:
        """Evaluate the current results, if there is ground truth."""
        workspace = self._context.workspace
        document = workspace.current if workspace.has_current else None
        if document is not self._answered:
            self._forget()
        if document is None:
            self._shown_frame = None
            self._panel.show_source(NO_FRAME)
            self._panel.show_ground_truth([], "")
            return
        frame, completion = document.frame, document.completion()
        self._show_source(document)
        if frame.ground_truth is None or completion is None:
            self._forget()
            self._panel.show_ground_truth([], _NO_GROUND_TRUTH if frame.ground_truth is None else _NO_RESULT)
            return
        entries = [EvaluatedResult("Current", completion, frame)]
        areas = self._areas(document)
        if self._panel.isVisible():
            for kept in document.compared:
                entries.append(EvaluatedResult(kept.name, kept.completion, kept.run.frame, kept.colour))
        else:
            areas = {}
        running = document in self._context.runs.running
        question = EvaluationRequest(
            document, frame.ground_truth, tuple(entries), document.labels.copy(), areas, self._panel.every, not running
        )
        if not self._panel.ground_truth_table.rows:
            self._panel.show_ground_truth([], _EVALUATING)
        self._answered = document
        self._questions.ask(question)

    def _areas(self, document: Document) -> dict[str, tuple[int, ...] | Box | None]:
        areas: dict[str, tuple[int, ...] | Box | None] = {"Frame": None}
        chosen = tuple(label for label in document.selected if label in document.counts())
        if chosen:
            areas[document.info(chosen[0]).name if len(chosen) == 1 else f"{len(chosen)} blocks"] = chosen
        if document.state.looked.region is not None:
            areas["Rectangle"] = document.state.looked.region
        return areas

    def _show_source(self, document: Document) -> None:
        frame = document.frame
        if frame is not self._shown_frame:
            self._shown_frame = frame
            file = None if frame.inputs is None else frame.inputs.ground_truth
            name = "given" if file is None else Path(file.path).name
            text = f"{document.name} has no ground truth."
            if frame.ground_truth is not None:
                text = f"Ground truth: {name}. {described(frame)}"
            self._panel.show_source(text, "" if file is None else file.path)

    def _take(self, question: EvaluationRequest, answer: EvaluationResult) -> None:
        if question.document is not self._answered:
            return
        self.blocks = {label: evaluated.rmse for label, evaluated in answer.blocks.items() if evaluated.pixels}
        if answer.areas:
            self._panel.show_ground_truth(ground_truth_rows(answer, question.entries), "")
        self.evaluated.emit()

    def _forget(self) -> None:
        self._answered = None
        self._questions.forget()
        if self.blocks:
            self.blocks = {}
            self.evaluated.emit()
        self._panel.show_ground_truth([], "")
