"""Accuracy of the depth: the panel, the ground truth, and the error column of the block table."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt

from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult
from ilf.errors import IlfError

from ...base.commands import Command
from ...base.needs import Need
from ...state.block_errors import GROUND_TRUTH, HOLD_OUT, BlockErrors
from ...state.document import Document
from ...widgets.docks import PanelGroup
from ...work.latest_request import LatestRequest
from ..context import Context, Feature, PendingWork
from .ground_truth import GroundTruthDialog, GroundTruthPresenter, GroundTruthSource, frame_with
from .hold_out import HoldOutPresenter
from .panel import AccuracyPanel

_TITLE = "Accuracy"


class AccuracyFeature(Feature):
    """The panel *Accuracy* and its commands."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        actions = context.actions
        actions.add(
            (
                Command(
                    "load_ground_truth",
                    "Load ground &truth…",
                    "Load the true depth of the frame, to evaluate results against it",
                    icon="ph.check-circle",
                    handler=self.ask_ground_truth,
                    needs=Need.FRAME,
                ),
                Command(
                    "remove_ground_truth",
                    "Remove ground truth",
                    "Remove the ground truth of the frame",
                    icon="ph.x-circle",
                    handler=self.remove_ground_truth,
                    why_off=self._why_no_ground_truth,
                ),
                Command(
                    "hold_out_test",
                    "&Hold-out test…",
                    "Hide some known depth, complete the frame without it, and compare the result with it",
                    icon="ph.test-tube",
                    handler=self.ask_test,
                    needs=Need.FRAME,
                ),
            )
        )
        self.panel = AccuracyPanel(
            [actions[name] for name in ("load_ground_truth", "hold_out_test", "remove_ground_truth")]
        )
        self.ground_truth = GroundTruthPresenter(context, self.panel)
        self.hidden = HoldOutPresenter(context, self.panel)
        self._reader = LatestRequest[GroundTruthSource, RGBDFrame](frame_with, self)
        context.panels.add(_TITLE, self.panel, PanelGroup.SETTINGS, "ph.target")
        workspace, panel = context.workspace, self.panel
        changed = workspace.frames.session_changed, workspace.labels_changed, workspace.runs.results_changed
        shown = (
            workspace.blocks.ground_truth_changed,
            workspace.blocks.infos_changed,
            workspace.blocks.selection_changed,
            panel.became_visible,
        )
        context.refresh.add(
            "accuracy",
            self.ground_truth.show,
            (*changed, *shown, workspace.blocks.region_changed, workspace.runs.compared_changed, panel.pixels_changed),
            (workspace.runs.results_added,),
        )
        context.refresh.add(
            "hold-out",
            self.hidden.show,
            (
                *(*changed, *shown, workspace.parameters.changed, panel.part_changed),
                *(workspace.blocks.invalid_mask_changed, workspace.blocks.guide_changed),
                workspace.blocks.neighbours_changed,
            ),
        )
        context.refresh.add(
            "block errors",
            self._update_block_errors,
            (
                *changed,
                workspace.blocks.ground_truth_changed,
                workspace.parameters.changed,
                self.ground_truth.evaluated,
                self.hidden.tested,
                workspace.runs.error_changed,
            ),
        )
        self._of: NDArray[np.float32] | None = None
        self._by_block = BlockErrors()
        """Expected errors of the blocks, from the expected error `_of`."""
        self._results: WeakValueDictionary[int, BlockResult] = WeakValueDictionary()
        """The results that `_by_block` belongs to."""
        workspace.frames.session_changed.connect(self._select_page)
        workspace.blocks.ground_truth_changed.connect(self._select_page)
        self._select_page()

    def ask_ground_truth(self) -> None:
        """Open the dialog that loads ground truth for the current frame."""
        document = self.context.workspace.current
        dialog = GroundTruthDialog(document.frame, self._reader, self.context.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take_ground_truth(document, dialog.found()))
        dialog.open()

    def load_ground_truth(self, path: str, units: float | None = None) -> bool:
        """Load the ground truth of the current frame from a file; False, with a message, if that fails."""
        document = self.context.workspace.current
        try:
            frame = frame_with(GroundTruthSource(document.frame, path, units))
        except IlfError as error:
            self.context.notes.report("Load ground truth", error)
            return False
        self._take_ground_truth(document, frame)
        return True

    def remove_ground_truth(self) -> None:
        """Remove the ground truth of the current frame."""
        self.context.workspace.current.set_ground_truth(None)
        self.context.notes.show_message("Ground truth removed.")

    def ask_test(self) -> None:
        """Open the dialog of the hold-out test, and the panel for its results."""
        self.context.panels.reveal(_TITLE)
        self.panel.show_page(hidden=True)
        self.hidden.ask()

    def pending_work(self) -> list[PendingWork]:
        """The hold-out test in progress, if any."""
        document = self.hidden.testing
        return [] if document is None else [PendingWork(f"a hold-out test of {document.name}", document)]

    def _take_ground_truth(self, document: Document, frame: RGBDFrame) -> None:
        workspace = self.context.workspace
        if document not in workspace.open:
            return
        workspace.show(document)  # another frame may have been opened meanwhile
        workspace.current.set_ground_truth(
            frame.ground_truth, None if frame.inputs is None else frame.inputs.ground_truth
        )
        self.context.panels.reveal(_TITLE)

    def _select_page(self) -> None:
        """Select the page of the panel."""
        self.panel.show_page(hidden=self.context.workspace.has_current and not self._has_ground_truth)

    @property
    def _has_ground_truth(self) -> bool:
        workspace = self.context.workspace
        return workspace.has_current and workspace.current.frame.ground_truth is not None

    def _why_no_ground_truth(self) -> str:
        none = "" if self._has_ground_truth else "This frame has no ground truth."
        return self.context.reasons.no_frame() or none

    def _update_block_errors(self) -> None:
        """Update the errors in the table of blocks."""
        workspace = self.context.workspace
        if not workspace.has_current:
            return
        document, outcome = workspace.current, self.hidden.outcome
        if document.frame.ground_truth is not None:
            errors = BlockErrors(GROUND_TRUTH, self.ground_truth.blocks)
        elif outcome is not None:
            errors = BlockErrors(HOLD_OUT, outcome.errors_of(document))
        else:
            errors = self._expected(document)
        document.set_block_errors(errors)

    def _expected(self, document: Document) -> BlockErrors:
        """Return the expected errors; until they are computed again, those of the blocks with unchanged results."""
        error, results = document.expected_error(), document.valid_results()
        if error is None:
            same = {label for label, result in results.items() if self._results.get(label) is result}
            kept = {label: rmse for label, rmse in self._by_block.rmse.items() if label in same}
            return replace(self._by_block, rmse=kept) if kept else BlockErrors()
        if error is not self._of:
            self._of, self._results = error, WeakValueDictionary(results)
            self._by_block = BlockErrors.expected(error, document.labels)
        return self._by_block
