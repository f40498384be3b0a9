"""The workspace: all changes of the window's state go through its five parts."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QUndoGroup

from ilf.run.run import Run

from .blocks import WorkspaceBlocks
from .by_hand import WorkspaceByHand
from .frames import WorkspaceFrames
from .parameters import WorkspaceParameters
from .parts import NO_PART, Part
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

    Signals
    -------
    changed(Part)
        What has changed of the current frame and of the list, once per turn of the event loop.
    """

    changed = Signal(object)
    _wanted = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.undo_group = QUndoGroup(self)
        self.frames = WorkspaceFrames(self.undo_group, self)
        self.parameters = WorkspaceParameters(self.frames, self)
        self.blocks = WorkspaceBlocks(self.frames, self.parameters, self)
        self.by_hand = WorkspaceByHand(self.frames, self.blocks, self)
        self.runs = WorkspaceRuns(self.frames, self.blocks, self.parameters, self)
        self._stale = NO_PART
        # not a timer with interval 0: the next user input would be handled before it
        self._wanted.connect(self.tell, Qt.ConnectionType.QueuedConnection)
        self._note_signals()

    def note(self, part: Part) -> None:
        """Note that a part has changed: `changed` tells it in the next turn of the event loop."""
        if not self._stale:
            self._wanted.emit()
        self._stale |= part

    def tell(self) -> None:
        """Tell now what would be told in the next turn."""
        part, self._stale = self._stale, NO_PART
        if part:
            self.changed.emit(part)

    def _note_signals(self) -> None:
        frames, blocks, runs = self.frames, self.blocks, self.runs
        for signal, part in (
            (frames.session_changed, Part.FRAME),
            (frames.sessions_changed, Part.LIST),
            (frames.entries.added, Part.LIST),
            (frames.entries.removed, Part.LIST),
            (frames.entries.changed, Part.LIST),
            (blocks.labels_changed, Part.LABELS),
            (blocks.stroke_changed, Part.STROKE),
            (blocks.replaced, Part.LABELS),
            (blocks.infos_changed, Part.INFOS),
            (blocks.selection_changed, Part.SELECTION),
            (blocks.invalid_mask_changed, Part.INVALID_MASK),
            (blocks.guide_changed, Part.GUIDE),
            (blocks.neighbours_changed, Part.NEIGHBOURS),
            (blocks.ground_truth_changed, Part.GROUND_TRUTH),
            (blocks.block_errors_changed, Part.BLOCK_ERRORS),
            (blocks.ignored_changed, Part.IGNORED),
            (blocks.region_changed, Part.REGION),
            (self.by_hand.changed, Part.BY_HAND),
            (self.by_hand.proposed, Part.BY_HAND),
            (self.parameters.changed, Part.PARAMETERS),
            (self.parameters.extraction_changed, Part.EXTRACTION),
            (runs.results_changed, Part.RESULTS),
            (runs.results_added, Part.SOME_RESULTS),
            (runs.records_added, Part.RECORDS),
            (runs.previews_changed, Part.PREVIEWS),
            (runs.error_changed, Part.EXPECTED_ERROR),
            (runs.history_changed, Part.HISTORY),
            (runs.compared_changed, Part.COMPARED),
            (runs.viewed_iteration_changed, Part.ITERATION),
        ):
            signal.connect(lambda *_, part=part: self.note(part))

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
