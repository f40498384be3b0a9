"""Accuracy of the depth: the panel, the ground truth, and the error column of the block table."""

from __future__ import annotations

from PySide6.QtCore import Qt

from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError

from ...base.commands import Command
from ...state.results import HIDDEN_DEPTH, TRUTH, BlockErrors
from ...state.session import Session
from ...work.latest_question import LatestQuestion
from ..context import Desk, Part, UnderWay
from .ground_truth import TruthDialog, TruthPresenter, TruthSource, frame_with
from .hold_out import HiddenPresenter
from .panel import AccuracyPanel

# Commands for ground truth, and for evaluation without it.

COMMANDS = (
    Command(
        "load_truth",
        "Load ground &truth…",
        "ph.check-circle",
        "",
        "Load the true depth of the frame, to evaluate results against it",
    ),
    Command("remove_truth", "Remove ground truth", "ph.x-circle", "", "Remove the ground truth of the frame"),
    Command(
        "test_hidden",
        "&Hold-out test…",
        "ph.test-tube",
        "",
        "Hide some known depth, complete the frame without it, and compare the result with it",
    ),
)


_TITLE = "Accuracy"


class AccuracyPart(Part):
    """The panel *Accuracy* and its commands."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        desk.actions.add(COMMANDS)
        actions = desk.actions
        self.panel = AccuracyPanel([actions[name] for name in ("load_truth", "test_hidden", "remove_truth")])
        self.truth = TruthPresenter(desk, self.panel)
        self.hidden = HiddenPresenter(desk, self.panel)
        self._reader = LatestQuestion[TruthSource, RGBDFrame](frame_with, self)
        desk.panels.add(_TITLE, self.panel, Qt.DockWidgetArea.RightDockWidgetArea, "ph.target", 3.2)
        actions["load_truth"].triggered.connect(lambda _=False: self.ask_truth())
        actions["remove_truth"].triggered.connect(lambda _=False: self.remove_truth())
        actions["test_hidden"].triggered.connect(lambda _=False: self.ask_test())
        workspace, panel = desk.workspace, self.panel
        changed = workspace.session_changed, workspace.labels_changed, workspace.results_changed
        shown = workspace.truth_changed, workspace.infos_changed, workspace.selection_changed, panel.looked_at
        desk.refresh.add(
            "accuracy",
            self.truth.show,
            (*changed, *shown, workspace.region_changed, workspace.compared_changed, panel.pixels_changed),
            (workspace.results_added,),
        )
        desk.refresh.add(
            "hold-out",
            self.hidden.show,
            (
                *(*changed, *shown, workspace.parameters_changed, panel.part_changed),
                *(workspace.distrusted_changed, workspace.guide_changed),
            ),
        )
        desk.refresh.add(
            "block errors",
            self._tell_errors,
            (*changed, workspace.truth_changed, workspace.parameters_changed, self.truth.judged, self.hidden.tested),
        )
        workspace.session_changed.connect(self._turn_page)
        workspace.truth_changed.connect(self._turn_page)
        self._turn_page()

    def ask_truth(self) -> None:
        """Open the dialog that loads ground truth for the current frame."""
        session = self.desk.workspace.session
        dialog = TruthDialog(session.frame, self._reader, self.desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take_truth(session, dialog.found()))
        dialog.open()

    def load_truth(self, path: str, units: float | None = None) -> bool:
        """Load the ground truth of the current frame from a file; False, with a message, if that fails."""
        session = self.desk.workspace.session
        try:
            frame = frame_with(TruthSource(session.frame, path, units))
        except IlfError as error:
            self.desk.notes.report("Load ground truth", error)
            return False
        self._take_truth(session, frame)
        return True

    def remove_truth(self) -> None:
        """Remove the ground truth of the current frame."""
        self.desk.workspace.set_truth(None)
        self.desk.notes.tell("Ground truth removed.")

    def ask_test(self) -> None:
        """Open the dialog of the hold-out test, and the panel for its results."""
        self.desk.panels.reveal(_TITLE)
        self.panel.turn_to(hidden=True)
        self.hidden.ask()

    def under_way(self) -> list[UnderWay]:
        """The hold-out test in progress, if any."""
        session = self.hidden.testing
        return [] if session is None else [UnderWay(f"a hold-out test of {session.name}", session)]

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if all threads have ended."""
        return all([self.truth.shutdown(), self.hidden.shutdown(), self._reader.shutdown()])

    def _take_truth(self, session: Session, frame: RGBDFrame) -> None:
        workspace = self.desk.workspace
        if session not in workspace.sessions:
            return
        workspace.show_session(session)  # another frame may have been opened meanwhile
        workspace.set_truth(frame.truth, None if frame.inputs is None else frame.inputs.truth)
        self.desk.panels.reveal(_TITLE)

    def _turn_page(self) -> None:
        """Select the page of the panel, and enable the commands."""
        workspace = self.desk.workspace
        has_truth = workspace.has_session and workspace.session.frame.truth is not None
        self.panel.turn_to(hidden=workspace.has_session and not has_truth)
        no_frame = "" if workspace.has_session else "Open a frame first."
        self.desk.actions.allow(no_frame, "load_truth", "test_hidden")
        self.desk.actions.allow(no_frame or ("" if has_truth else "This frame has no ground truth."), "remove_truth")

    def _tell_errors(self) -> None:
        """Update the errors in the table of blocks."""
        workspace = self.desk.workspace
        if not workspace.has_session:
            return
        session, outcome = workspace.session, self.hidden.outcome
        if session.frame.truth is not None:
            errors = BlockErrors(TRUTH, self.truth.blocks)
        elif outcome is not None:
            errors = BlockErrors(HIDDEN_DEPTH, outcome.errors_of(session))
        else:
            errors = BlockErrors()
        workspace.set_block_errors(session, errors)
