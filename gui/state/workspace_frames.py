"""Frames of the workspace, the current frame, and the signals of all changes. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from weakref import ref

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup, QUndoStack

from ilf.data.parameters import DEFAULT_PRESET, BlockParameters, Parameters, preset
from ilf.project.frame_state import own_values
from ilf.run.run import Run
from ilf.segmentation.editing.patches import LabelPatch

from .commands import Change
from .entries import Entries, Entry
from .results import ViewedIteration
from .session import Session
from .sharing import SharedParameters
from .stroke import StrokeInProgress


class WorkspaceFrames(QObject):
    """The frames, open or not, and the signals of all changes.

    Signals carry no data that could go stale: listeners read the workspace. Signals about a session are emitted for
    the current frame only; for other frames, `sessions_changed` is.
    """

    about_to_change = Signal()
    """The current frame or its label map is about to change: strokes in progress must end."""
    sessions_changed = Signal()
    """Frames were opened or closed, or their summaries in the list changed."""
    session_changed = Signal()
    labels_changed = Signal(object)
    """The box (rows, columns) of the label map that changed."""
    stroke_changed = Signal(object)
    """The same, by a stroke in progress, which may still be cancelled."""
    infos_changed = Signal()
    results_changed = Signal()
    """Results changed or were removed, or a run has ended."""
    results_added = Signal()
    """The run in progress has new results; up to several times a second."""
    records_added = Signal()
    """Running blocks have new records."""
    previews_changed = Signal()
    """The depth of running blocks has changed."""
    error_changed = Signal()
    """The expected error of the results was computed."""
    touched = Signal(object)
    """Content of a Session, current or not, that a project stores has changed."""
    project_touched = Signal()
    """Content of the project apart from its frames has changed: the list and its order, shared settings."""
    edited = Signal(object)
    """An edit of the label map was made, undone or redone: a `Change`."""
    replaced = Signal()
    """All blocks of the current frame were replaced, or restored by undo; not an edit."""
    invalid_mask_changed = Signal()
    """The invalid mask of the current frame has changed."""
    guide_changed = Signal()
    """The guide of the current frame has changed or was removed."""
    ground_truth_changed = Signal()
    """The ground truth of the current frame has changed or was removed."""
    block_errors_changed = Signal()
    """The known errors of blocks have changed."""
    region_changed = Signal()
    """The rectangle of the current frame has changed or was removed."""
    run_history_changed = Signal()
    """The run history of the current frame has changed."""
    viewed_iteration_changed = Signal()
    """The iteration that the views show has changed."""
    compared_changed = Signal()
    """The set of compared runs has changed."""
    selection_changed = Signal()
    parameters_changed = Signal()
    """Of the filter."""
    extraction_changed = Signal()
    """Extraction parameters, or which blocks an extraction keeps."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sessions: list[Session] = []
        """The frames that are open."""
        self.entries = Entries(self)
        """All frames, open or not."""
        self.undo_group = QUndoGroup(self)
        self.shared = SharedParameters(False, preset(DEFAULT_PRESET))
        """Whether parameters are shared, and which; if not, a new frame starts with those of the current frame."""
        self.extraction_parameters = BlockParameters()
        self.keeps_handmade = True
        """Whether a new extraction keeps hand-made blocks, as it keeps locked ones."""
        self._session: Session | None = None
        self._empty_stack = QUndoStack(self)
        self._stroke: StrokeInProgress | None = None
        self.viewed_iteration: ViewedIteration | None = None
        """The earlier iteration that the views show instead of the current depth."""
        self._with_key_frames: list[Session] = []
        """Frames with key frames, the last run at the end."""

    @property
    def session(self) -> Session:
        """The current frame's session; only valid while `has_session`."""
        if self._session is None:
            raise RuntimeError("no frame is open")
        return self._session

    @property
    def has_session(self) -> bool:
        """Whether a frame is open."""
        return self._session is not None

    @property
    def parameters(self) -> Parameters:
        """Common parameters of the current frame: those of all blocks without own parameters."""
        return self.shared.values if self._session is None else self._session.common

    @property
    def next_parameters(self) -> Parameters:
        """Parameters that the next frame starts with."""
        return self.shared.values if self.shared.on else self.parameters

    def is_current(self, session: Session) -> bool:
        """Whether this is the current frame's session."""
        return session is self._session

    @property
    def chosen(self) -> int:
        """The first selected block, which edits and curves use; 0 for none."""
        return self._session.selected[0] if self._session is not None and self._session.selected else 0

    def session_of(self, key: str) -> Session | None:
        """Return the open session of a file or folder; None if there is none."""
        return next((session for session in self.sessions if session.key == key), None)

    def add_session(
        self, session: Session, recorded: Run | None = None, restored: bool = False, show: bool = True
    ) -> None:
        """Open a frame and, with `show`, make it the current one.

        It starts with the parameters of the current frame, or the shared ones, unless it is `restored`. With
        `recorded`, it takes the parameters and the extraction parameters of that run, and the blocks that were run are
        selected if they are not all.
        """
        if restored:
            self.shared.apply_to(session)
        else:
            session.take_common(self.next_parameters)
        if recorded is not None:
            self._apply_recorded(session, recorded)
        self.sessions.append(session)
        listed = len(self.entries)
        self.entries.attach(session)
        self.undo_group.addStack(session.undo_stack)
        opened = ref(session)  # a strong reference would keep the session alive through its history
        session.undo_stack.indexChanged.connect(lambda _: self._note_step(opened()))
        self.sessions_changed.emit()
        if show:
            self.show_session(session)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def _apply_recorded(self, session: Session, recorded: Run) -> None:
        session.take_common(recorded.parameters)
        session.own_parameters = self.shared.on and recorded.parameters != self.shared.values
        if recorded.extraction is not None:
            self.set_extraction_parameters(recorded.extraction)
        labels = set(session.counts()) if recorded.only is None else set(recorded.only)
        own = {label: own_values(recorded.parameters_of(label), recorded.parameters) for label in labels}
        session.notes.own.update({label: values for label, values in own.items() if values})
        if labels != set(session.counts()):
            session.selected = sorted(labels)

    def show_session(self, session: Session | None) -> None:
        """Make a frame the current one."""
        if session is self._session:
            return
        self._end_strokes()
        self.shared = SharedParameters(self.shared.on, self.next_parameters)
        self._session = session
        self.undo_group.setActiveStack(session.undo_stack if session else self._empty_stack)
        self.session_changed.emit()

    def close_session(self, session: Session) -> None:
        """Close a frame permanently; the previous one in the list becomes the current one."""
        entry = self.entries.of(session.id)
        self._close(session)
        if entry is not None:
            self.remove_entries([entry])

    def unload(self, session: Session, stored: bool = True) -> None:
        """Close a frame whose state is stored, or that has none; its entry stays, and it can be opened again in the
        same state, without its undo history."""
        entry = self.entries.of(session.id)
        if entry is not None:
            self.entries.detach(entry, stored)
        self._close(session)

    def add_entries(self, entries: Sequence[Entry]) -> None:
        """Add frames to the list without opening them."""
        self.entries.add(entries)
        self.project_touched.emit()

    def remove_entries(self, entries: Collection[Entry]) -> None:
        """Remove frames from the list permanently, and close those that are open."""
        gone = {entry.session for entry in entries if entry.session is not None}
        if self._session in gone:  # show the nearest remaining frame
            position = self.sessions.index(self._session)
            nearest = [*reversed(self.sessions[:position]), *self.sessions[position:]]
            self.show_session(next((session for session in nearest if session not in gone), None))
        for session in [session for session in self.sessions if session in gone]:
            self._close(session)
        self.entries.remove(entries)
        self.project_touched.emit()

    def note_problem(self, entry: Entry, problem: str) -> None:
        """Store why a frame of the list could not be opened."""
        self.entries.note_problem(entry, problem)
        self.project_touched.emit()

    def _close(self, session: Session) -> None:
        position = self.sessions.index(session)
        self.sessions.remove(session)
        self._with_key_frames = [one for one in self._with_key_frames if one is not session]
        if session is self._session:
            self.show_session(self.sessions[max(position - 1, 0)] if self.sessions else None)
        self.undo_group.removeStack(session.undo_stack)
        session.undo_stack.setParent(None)  # PySide treats it as owned by the group while the group exists
        session.undo_stack.clear()  # commands and session reference each other and would never be freed
        self.sessions_changed.emit()

    def note_saved(self, session: Session, stamp: tuple[int, int, int]) -> None:
        """Mark the state of a session at a `Session.stamp` as saved."""
        session.note_saved(stamp)
        self.sessions_changed.emit()

    def touch(self, session: Session, viewing: bool = False) -> None:
        """Note a change of project content; `viewing`: only of the view, which is stored but needs no saving."""
        if not viewing:
            session.note_other_change()
        if session in self.sessions:
            self.touched.emit(session)

    def _note_step(self, session: Session | None) -> None:
        """Note that a step of a frame was made, undone or redone."""
        if session is not None and session in self.sessions:
            self.touched.emit(session)

    def set_note(self, entry: Entry, note: str) -> None:
        """Set the user's note on a frame, open or not."""
        if note == entry.note:
            return
        if entry.session is None:
            self.entries.set_note(entry, note)
        else:
            entry.session.note = note
            self.touch(entry.session)
        self.sessions_changed.emit()
        self.project_touched.emit()

    def set_extraction_parameters(self, parameters: BlockParameters) -> None:
        """Set the parameters of the next extraction."""
        self.extraction_parameters = parameters
        self.extraction_changed.emit()
        self.project_touched.emit()

    # selection and strokes

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke; `end_stroke` makes it an undo step, `drop_stroke` cancels it."""
        if patch is None:
            return
        if self._stroke is None:
            self._stroke = StrokeInProgress(self.session.labels)
        self._stroke.reach(patch.box)
        self.session.apply(patch)
        self.stroke_changed.emit(patch.box)

    @property
    def stroke_in_progress(self) -> bool:
        """Whether a stroke is in progress."""
        return self._stroke is not None

    def drop_stroke(self) -> bool:
        """Restore the pixels of the stroke in progress; False if there is none."""
        patch = self._take_stroke()
        if patch is None:
            return False
        self.session.apply(patch, forward=False)
        self.stroke_changed.emit(patch.box)
        return True

    def _take_stroke(self) -> LabelPatch | None:
        stroke, self._stroke = self._stroke, None
        return None if stroke is None else stroke.patch(self.session.labels)

    def _end_strokes(self) -> None:
        self.about_to_change.emit()
        self.drop_stroke()

    def select(self, labels: list[int]) -> None:
        """Select blocks; edits and curves use the first one."""
        if self.has_session:
            self._select(self.session, labels)

    def _select(self, session: Session, labels: list[int]) -> None:
        if labels != session.selected:
            session.selected = labels
            if session is self._session:
                self.selection_changed.emit()

    # notifications from commands

    def prepare_change(self, session: Session) -> None:
        """End strokes before the label map of a session changes."""
        if session is self._session:
            self._end_strokes()

    def note_labels_changed(self, session: Session, patch: LabelPatch | None, change: Change | None = None) -> None:
        """Called by commands after the label map or block attributes have changed; with `change`, by an edit."""
        if session is not self._session:
            self.sessions_changed.emit()
            return
        if patch is not None:
            left = session.counts()
            # a new block that is not painted yet stays selected
            gone = [
                label
                for label in session.selected
                if label not in left and ((patch.before == label).any() or (patch.after == label).any())
            ]
            self.labels_changed.emit(patch.box)
            if gone:
                self.select([label for label in session.selected if label not in gone])
        if change is None:
            self.replaced.emit()
        else:
            self.edited.emit(change)
        self.results_changed.emit()

    def note_results_changed(self, session: Session) -> None:
        """Called after results were added, removed or restored."""
        (self.results_changed if session is self._session else self.sessions_changed).emit()

    def note_invalid_mask_changed(self, session: Session) -> None:
        """Called by commands after the invalid mask has changed."""
        if session is self._session:
            self.invalid_mask_changed.emit()
        self.note_results_changed(session)

    def note_guide_changed(self, session: Session) -> None:
        """Called by commands after the guide has changed."""
        if session is self._session:
            self.guide_changed.emit()
        self.note_results_changed(session)

    def note_checked(self, session: Session) -> None:
        """Called by commands after the set of blocks to check has changed."""
        self.note_infos_changed(session)
        self.sessions_changed.emit()

    def note_infos_changed(self, session: Session) -> None:
        """Called by commands after a name, colour or lock has changed."""
        if session is self._session:
            self.infos_changed.emit()
