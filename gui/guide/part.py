"""The guide of a frame: loaded by a dialog, removed, and said what it is."""

from __future__ import annotations

from pathlib import Path
from weakref import WeakSet

from PySide6.QtCore import Qt

from gui.desk import Desk, Part
from gui.guide.commands import COMMANDS
from gui.guide.dialog import Guided, GuideDialog, GuideSource, described, guided
from gui.state.session import Session
from gui.work.latest_question import LatestQuestion
from ilf.errors import IlfError


class GuidePart(Part):
    """The commands on the guide."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        actions, workspace = desk.actions, desk.workspace
        actions.add(COMMANDS)
        self._reader = LatestQuestion[GuideSource, Guided](guided, self)
        actions["load_guide"].triggered.connect(lambda _=False: self.ask())
        actions["remove_guide"].triggered.connect(lambda _=False: self.remove())
        for changed in (workspace.session_changed, workspace.guide_changed):
            changed.connect(self._allow)
        self._told: WeakSet[Session] = WeakSet()
        """Frames that it has been said of that they came with a guide, or that have been given one."""
        self._allow()

    def ask(self) -> None:
        """Load a guide of the present frame, by the dialog."""
        session = self.desk.workspace.session
        dialog = GuideDialog(session.frame, self._reader, self.desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take(session, dialog.found()))
        dialog.open()

    def load(self, path: str) -> bool:
        """Take the guide of the present frame from a file; False, with a message, if it cannot be."""
        session = self.desk.workspace.session
        try:
            found = guided(GuideSource(session.frame, path))
        except IlfError as error:
            self.desk.notes.report("Load guide", error)
            return False
        self._take(session, found)
        return True

    def remove(self) -> None:
        """Complete the present frame without a guide."""
        self.desk.workspace.set_guide(None, "Remove guide")
        self.desk.notes.tell("The guide is removed.")

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread of it is left."""
        return self._reader.shutdown()

    def _take(self, session: Session, found: Guided) -> None:
        workspace, guide = self.desk.workspace, found.frame.guide
        if session not in workspace.sessions or guide is None:
            return
        workspace.show_session(session)  # another may have been opened meanwhile
        self._told.add(session)
        workspace.set_guide(guide, "Load guide")
        name = "" if guide.path is None else f" {Path(guide.path).name}"
        self.desk.notes.tell(f"Guide{name}: {described(found.fitted)}")

    def _allow(self) -> None:
        workspace = self.desk.workspace
        no_frame = "" if workspace.has_session else "Open a frame first."
        has_guide = workspace.has_session and workspace.session.frame.guide is not None
        if has_guide and workspace.session not in self._told:
            self._told.add(workspace.session)
            name = workspace.session.name
            self.desk.notes.tell(f"{name} has a guide, which runs follow. To go without: File > Remove guide.")
        self.desk.actions.allow(no_frame, "load_guide")
        self.desk.actions.allow(no_frame or ("" if has_guide else "This frame has no guide."), "remove_guide")
