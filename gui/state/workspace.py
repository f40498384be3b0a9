"""The workspace: all changes of the window's state go through its five parts."""

from __future__ import annotations

from PySide6.QtCore import QObject
from PySide6.QtGui import QUndoGroup

from ilf.run.run import Run

from .blocks import WorkspaceBlocks
from .by_hand import WorkspaceByHand
from .frames import WorkspaceFrames
from .parameters import WorkspaceParameters
from .runs import WorkspaceRuns
from .session import Session


class Workspace(QObject):
    """The state of the window. Every change is a method of one of its parts, which emits a signal.

    Later parts know earlier ones, and listen to them.

    Attributes
    ----------
    frames : WorkspaceFrames
    parameters : WorkspaceParameters
    blocks : WorkspaceBlocks
    by_hand : WorkspaceByHand
    runs : WorkspaceRuns
    undo_group : QUndoGroup
        The undo histories of all frames; that of the current frame is the active one.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.undo_group = QUndoGroup(self)
        self.frames = WorkspaceFrames(self.undo_group, self)
        self.parameters = WorkspaceParameters(self.frames, self)
        self.blocks = WorkspaceBlocks(self.frames, self.parameters, self)
        self.by_hand = WorkspaceByHand(self.frames, self.blocks, self)
        self.runs = WorkspaceRuns(self.frames, self.blocks, self.parameters, self)

    @property
    def session(self) -> Session:
        """The current frame's session; only valid while `has_session`."""
        return self.frames.session

    @property
    def has_session(self) -> bool:
        """Whether a frame is open."""
        return self.frames.has_session

    def add_session(
        self, session: Session, recorded: Run | None = None, restored: bool = False, show: bool = True
    ) -> None:
        """Open a frame and, with `show`, make it the current one.

        It starts with the parameters of the current frame, or the shared ones, unless it is `restored`. With
        `recorded`, it takes the parameters and the extraction parameters of that run, and the blocks that were run are
        selected if they are not all.
        """
        self.parameters.start(session, recorded, restored)
        if recorded is not None and recorded.only is not None and set(recorded.only) != set(session.counts()):
            session.change(selected=tuple(sorted(set(recorded.only))))
        self.frames.add(session, show)
