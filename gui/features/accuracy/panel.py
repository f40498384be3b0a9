"""The panel *Accuracy*: errors against ground truth, and of hold-out tests."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QTabWidget, QWidget

from ilf.data.frame import RGBDFrame

from ...base.commands import command
from ...base.needs import Need
from ...state.document import Document
from ...state.parts import Part
from ...widgets.basics import (
    TEXT,
    Message,
    PlainLabel,
    combo,
    command_button,
    label_of,
    lay_out,
    literal_text,
    open_once,
    page,
)
from ...widgets.docks import PanelGroup
from ...widgets.row_table import NumberTable
from ...work.latest_request import LatestRequest
from ..blocks.feature import BlocksFeature
from ..context import Context
from ..panel import Panel
from .evaluation import (
    GROUND_TRUTH_COLUMNS,
    AreaErrors,
    EvaluatedResult,
    ExpectedErrors,
    evaluate_areas,
    ground_truth_rows,
)
from .ground_truth import GroundTruthDialog, described
from .hold_out import HOLD_OUT_COLUMNS, HoldOutDialog, HoldOutOutcome, candidates, outcome_steps

_NO_FRAME = "Open a frame to evaluate it."
_NO_GROUND_TRUTH = "No ground truth: load it, or run a hold-out test."
_NO_RESULT = "No result to evaluate yet: run the filter."
_EVALUATING = "Evaluating…"
_NOT_TESTED = "Not tested yet. The hold-out test hides known depth and measures the error of its completion."


class AccuracyPanel(Panel):
    """The panel with the errors of the current result and of compared runs, and of candidates of a hold-out test.

    Attributes
    ----------
    outcomes : mapping of Document to HoldOutOutcome
        The last hold-out test of each frame.
    """

    title, icon, group = "Accuracy", "ph.target", PanelGroup.SETTINGS
    parts = (
        Part.FRAME
        | Part.LABELS
        | Part.INFOS
        | Part.SELECTION
        | Part.INVALID_MASK
        | Part.GROUND_TRUTH
        | Part.REGION
        | Part.PARAMETERS
        | Part.RESULTS
        | Part.COMPARED
    )
    deferred = Part.SOME_RESULTS
    what = "hold-out test"

    def __init__(self, context: Context) -> None:
        self.outcomes: WeakKeyDictionary[Document, HoldOutOutcome] = WeakKeyDictionary()
        super().__init__(context)
        self._evaluations = LatestRequest(self, partial(context.notes.report, "Evaluation against ground truth"))
        self._reader = LatestRequest(self)
        self._expected: ExpectedErrors = WeakKeyDictionary()
        self.workspace.on(Part.LIST, self._cancel_closed)
        self.requests.ended.connect(self.redraw)

    def make(self) -> QWidget:
        self.work.cancelled.connect(lambda: self.notes.show_message("The hold-out test was cancelled."))
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.addTab(self._ground_truth_page(), "Ground truth")
        self.tabs.addTab(self._hold_out_page(), "Hold-out")
        self.context.actions["sweep"].setIconText("Sweep…")
        corner = QWidget()
        lay_out(QHBoxLayout(corner), command_button(self.context.actions["sweep"], TEXT), margins=(0, 0, 6, 2))
        self.tabs.setCornerWidget(corner)
        self.tabs.currentChanged.connect(lambda _: self.redraw())
        self.tabs.setMinimumSize(260, 150)
        return self.tabs

    def _ground_truth_page(self) -> QWidget:
        self.source = Message()
        hint = "Evaluate only filled pixels, or also pixels with known depth"
        self.pixels = combo(["Filled pixels", "All pixels"], hint)
        self.pixels.activated.connect(lambda _: self.redraw())
        self.ground_truth_table = NumberTable("Errors against ground truth", GROUND_TRUTH_COLUMNS)
        buttons = (
            command_button(self.context.actions["load_ground_truth"], TEXT),
            command_button(self.context.actions["remove_ground_truth"]),
        )
        choice = label_of("&Evaluate", self.pixels), self.pixels
        return page(_row(*buttons), self.source, _row(*choice, unit=True), self.ground_truth_table)

    def _hold_out_page(self) -> QWidget:
        hint = "Show the errors of all blocks together, or of the selected block"
        self.part = combo(["All blocks", "Selected block"], hint)
        self.part.activated.connect(lambda _: self.redraw())
        self.part.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.part.setMinimumContentsLength(14)
        self.outcome = Message()
        self.hold_out_table = NumberTable("Hold-out errors", HOLD_OUT_COLUMNS)
        choice = label_of("Errors &of", self.part), self.part
        above = _row(command_button(self.context.actions["hold_out_test"], TEXT)), self.work, self.outcome
        return page(*above, _row(*choice, unit=True), self.hold_out_table)

    def refresh(self, parts: Part) -> None:
        document = self.workspace.shown
        if parts & (Part.FRAME | Part.GROUND_TRUTH | Part.INVALID_MASK):
            self._show_source(document)
        if parts & (Part.FRAME | Part.GROUND_TRUTH):
            with QSignalBlocker(self.tabs):
                self.tabs.setCurrentIndex(int(document is not None and document.frame.ground_truth is None))
            self._forget_errors("")
        if self.tabs.currentIndex() == 1:
            self._show_hold_out(document)
        elif document is not None and parts != Part.PARAMETERS:  # the results still are those of the former ones
            self._evaluate(document)

    # ground truth

    @command("load_ground_truth", "Load gro&und truth…", icon="ph.check-circle", needs=Need.FRAME)
    def _ask_ground_truth(self) -> None:
        """Load the true depth of the frame, to evaluate results against it."""
        document = self.workspace.current
        dialog = GroundTruthDialog(document.frame, self._reader, self.context.window)
        open_once(dialog, lambda: self._take_ground_truth(document, dialog.seen.found))

    def _take_ground_truth(self, document: Document, frame: RGBDFrame) -> None:
        if document not in self.workspace.open:
            return
        self.workspace.show(document)  # another frame may have been opened meanwhile
        self.workspace.current.set_ground_truth(
            frame.ground_truth, None if frame.inputs is None else frame.inputs.ground_truth
        )
        self.reveal()

    @command("remove_ground_truth", "Remove ground truth", icon="ph.x-circle", needs=Need.GROUND_TRUTH)
    def _remove_ground_truth(self) -> None:
        """Remove the ground truth of the frame."""
        self.workspace.current.set_ground_truth(None)
        self.notes.show_message("Ground truth removed.")

    def _show_source(self, document: Document | None) -> None:
        file = None if document is None or document.frame.inputs is None else document.frame.inputs.ground_truth
        if document is None:
            text = _NO_FRAME
        elif document.frame.ground_truth is None:
            text = f"{document.name} has no ground truth."
        else:
            text = f"Ground truth: {'given' if file is None else Path(file.path).name}. {described(document.frame)}"
        self.source.show_message(text)
        self.source.setToolTip("" if file is None else literal_text(file.path))

    def _evaluate(self, document: Document) -> None:
        """Have the current result and the compared runs evaluated, if there is ground truth."""
        completion, ground_truth = document.completion(), document.frame.ground_truth
        if ground_truth is None or completion is None:
            self._forget_errors(_NO_GROUND_TRUTH if ground_truth is None else _NO_RESULT)
            return
        entries = [EvaluatedResult("Current", completion)]
        entries += [EvaluatedResult(kept.name, kept.completion, kept.colour) for kept in document.compared]
        if not self.ground_truth_table.numbers:
            self.ground_truth_table.set_rows([], _EVALUATING)
        labels, areas, every = document.labels.copy(), _areas(document), self.pixels.currentIndex() == 1
        expected, with_expected = self._expected, document not in self.context.runs.running

        def show(found: dict[str, AreaErrors]) -> None:
            self.ground_truth_table.set_rows(ground_truth_rows(found, entries))
            self.pixels.setEnabled(True)

        self._evaluations.ask(
            lambda: evaluate_areas(ground_truth, entries, labels, areas, every, expected, with_expected),
            show,
        )

    def _forget_errors(self, empty: str) -> None:
        self._evaluations.forget()
        self.ground_truth_table.set_rows([], empty)
        self.pixels.setEnabled(False)

    # hold-out test

    @command("hold_out_test", "&Hold-out test…", icon="ph.test-tube", needs=Need.FRAME)
    def _ask_test(self) -> None:
        """Hide some known depth, complete the frame without it, and compare the result with it."""
        self.reveal()
        self.context.refresh.now()  # it turns to the page that fits the frame
        self.tabs.setCurrentIndex(1)
        if self.busy:
            self.notes.show_message("A hold-out test is already in progress.")
            return
        document = self.workspace.current
        present = document.run(document.state.common)
        last = self.outcomes.get(document)
        tested = [] if last is None else [one.name for one in last.candidates]
        dialog = HoldOutDialog(document.name, candidates(document, present, tested), self.context.window)

        def start() -> None:
            chosen, test = dialog.chosen(), dialog.hold_out.test()
            self.requests.ask(
                lambda: outcome_steps(chosen, present, test),
                partial(self._take_outcome, document),
                what=f"a hold-out test of {document.name}",
                about=document,
            )
            self.redraw()

        open_once(dialog, start)

    def _take_outcome(self, document: Document, outcome: HoldOutOutcome) -> None:
        if document not in self.workspace.open:
            return
        self.outcomes[document] = outcome
        for candidate, whole in zip(outcome.candidates, outcome.errors[0].evaluated, strict=True):
            kept = candidate.kept
            if kept in document.state.runs and kept.run is candidate.run:  # a slider drag changes it
                document.change_run(kept, hold_out_error=whole.rmse, hold_out_test=outcome.test)
        self.context.feature(BlocksFeature).take_hold_out(document, outcome.errors_of)

    def _cancel_closed(self) -> None:
        """Cancel the test if its frame was closed."""
        if any(test.about not in self.workspace.open for test in self.pending_work()):
            self.requests.cancel()

    def _show_hold_out(self, document: Document | None) -> None:
        chosen = self.workspace.chosen
        name = document.info(chosen).name if document and chosen else ""
        self.part.setItemText(1, f"{name} only" if name else "Selected block (none selected)")
        outcome = None if document is None else self.outcomes.get(document)
        text, tone, rows, empty = "", "muted", [], _NOT_TESTED if document else _NO_FRAME
        if document is not None and outcome is not None:
            text, tone = outcome.described(document)
            of_block = self.part.currentIndex() == 1
            empty = "Select a block to see its errors."
            rows = [] if of_block and not chosen else outcome.rows(chosen if of_block else 0)
        elif any(test.about is document for test in self.pending_work()):
            empty = "Testing…"
        self.outcome.setVisible(bool(text))
        self.outcome.show_message(text, tone)
        self.hold_out_table.set_rows(rows, empty)
        self.part.setEnabled(outcome is not None)


def _areas(document: Document) -> dict[str, NDArray[np.bool_]]:
    """The frame, the selected blocks and the rectangle, as masks."""
    areas = {"Frame": np.ones(document.labels.shape, bool)}
    chosen = [label for label in document.selected if label in document.counts()]
    if chosen:
        name = document.info(chosen[0]).name if len(chosen) == 1 else f"{len(chosen)} blocks"
        areas[name] = np.isin(document.labels, chosen)
    if (region := document.state.looked.region) is not None:
        areas["Rectangle"] = np.zeros(document.labels.shape, bool)
        areas["Rectangle"][region] = True
    return areas


def _row(*widgets: QWidget, unit: bool = False) -> QHBoxLayout:
    """Widgets side by side; with the unit of the errors at the right."""
    row = lay_out(QHBoxLayout(), *widgets, None, spacing=6)
    if unit:
        row.addWidget(PlainLabel("Errors in mm"))
    return row
