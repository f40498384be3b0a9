"""How far off the depth is: the panel, the truth it is judged by, and the column of the table of blocks."""

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

# Commands on the truth, and on judging without one.

COMMANDS = (
    Command(
        "load_truth", "Load &truth…", "ph.check-circle", "", "Take the true depth of the frame, to judge results by"
    ),
    Command("remove_truth", "Remove truth", "ph.x-circle", "", "Judge the frame by no truth any more"),
    Command(
        "test_hidden",
        "Test on &hidden depth…",
        "ph.test-tube",
        "",
        "Hide some of the known depth, complete the frame without it, and see how far off it comes out",
    ),
)


_TITLE = "Accuracy"


class AccuracyPart(Part):
    """The panel *Accuracy*, with its commands."""

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
            "hidden depth",
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
        """Load a truth of the present frame, by the dialog."""
        session = self.desk.workspace.session
        dialog = TruthDialog(session.frame, self._reader, self.desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take_truth(session, dialog.found()))
        dialog.open()

    def load_truth(self, path: str, units: float | None = None) -> bool:
        """Take the truth of the present frame from a file; False, with a message, if it cannot be."""
        session = self.desk.workspace.session
        try:
            frame = frame_with(TruthSource(session.frame, path, units))
        except IlfError as error:
            self.desk.notes.report("Load truth", error)
            return False
        self._take_truth(session, frame)
        return True

    def remove_truth(self) -> None:
        """Judge the present frame by no truth."""
        self.desk.workspace.set_truth(None)
        self.desk.notes.tell("The truth is removed: the frame is judged by none.")

    def ask_test(self) -> None:
        """Test on hidden depth, by the dialog; what comes is shown."""
        self.desk.panels.reveal(_TITLE)
        self.panel.turn_to(hidden=True)
        self.hidden.ask()

    def under_way(self) -> list[UnderWay]:
        """The test on hidden depth, if one is under way."""
        session = self.hidden.testing
        return [] if session is None else [UnderWay(f"a test of {session.name} on hidden depth", session)]

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread of it is left."""
        return all([self.truth.shutdown(), self.hidden.shutdown(), self._reader.shutdown()])

    def _take_truth(self, session: Session, frame: RGBDFrame) -> None:
        workspace = self.desk.workspace
        if session not in workspace.sessions:
            return
        workspace.show_session(session)  # another may have been opened meanwhile
        workspace.set_truth(frame.truth, None if frame.inputs is None else frame.inputs.truth)
        self.desk.panels.reveal(_TITLE)

    def _turn_page(self) -> None:
        """What there is to be seen; the commands that there is something for."""
        workspace = self.desk.workspace
        has_truth = workspace.has_session and workspace.session.frame.truth is not None
        self.panel.turn_to(hidden=workspace.has_session and not has_truth)
        no_frame = "" if workspace.has_session else "Open a frame first."
        self.desk.actions.allow(no_frame, "load_truth", "test_hidden")
        self.desk.actions.allow(no_frame or ("" if has_truth else "This frame has no truth."), "remove_truth")

    def _tell_errors(self) -> None:
        """What the table of blocks says."""
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
