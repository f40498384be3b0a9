"""Which frames are worked on, which is the present one, and who is told of changes. Signals, no widgets."""

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
from .results import Past
from .session import Session
from .sharing import Shared
from .stroke import StrokeUnderWay


class FramesAtWork(QObject):
    """The frames, open or not, and the signals of all that may change.

    Signals carry no data that could go stale: who listens reads the workspace. Those of a session are sent for the
    present one only; of the others, `sessions_changed` tells.
    """

    about_to_change = Signal()
    """The present frame is about to be left, or its label map to be changed: strokes under way must end."""
    sessions_changed = Signal()
    """Frames were opened or closed, or what the list says of them has changed."""
    session_changed = Signal()
    labels_changed = Signal(object)
    """The box (rows, columns) of the label map that changed."""
    stroke_changed = Signal(object)
    """The same, by a stroke that is under way and may yet be given up."""
    infos_changed = Signal()
    results_changed = Signal()
    """Other results, or none, or a run has ended."""
    results_added = Signal()
    """Some of a run under way have come: several times a second, it may be."""
    records_added = Signal()
    """Blocks that run have new records."""
    previews_changed = Signal()
    """Blocks that run have other depth."""
    error_changed = Signal()
    """The expected error of the results has been worked out."""
    touched = Signal(object)
    """A Session, the present one or another, has changed in something that a project holds."""
    project_touched = Signal()
    """What a project holds beside its frames has changed: which there are, in which order, what is set for all."""
    edited = Signal(object)
    """An edit of the label map has been made, undone or made again: a `Change`."""
    replaced = Signal()
    """All blocks of the present frame have given way to others, or have come back: no edit."""
    distrusted_changed = Signal()
    """Other depth of the present frame is distrusted."""
    guide_changed = Signal()
    """The present frame has another guide, or none."""
    truth_changed = Signal()
    """The present frame has another truth, or none."""
    block_errors_changed = Signal()
    """Other errors of blocks are known."""
    region_changed = Signal()
    """Another rectangle of the present frame is chosen, or none."""
    kept_runs_changed = Signal()
    """Runs of the present frame have been kept, changed or deleted."""
    past_changed = Signal()
    """The views look back to another iteration, or no longer."""
    compared_changed = Signal()
    """Others of the kept runs are compared."""
    selection_changed = Signal()
    parameters_changed = Signal()
    """Of the filter."""
    extraction_changed = Signal()
    """Parameters of the extraction, or which blocks it keeps."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sessions: list[Session] = []
        """The frames that are open."""
        self.entries = Entries(self)
        """All frames, open or not."""
        self.undo_group = QUndoGroup(self)
        self.shared = Shared(False, preset(DEFAULT_PRESET))
        """Whether parameters are for all frames; while they are not, and a frame is open, the next begins with its."""
        self.extraction_parameters = BlockParameters()
        self.keeps_handmade = True
        """Whether blocks that were made by hand stay when blocks are extracted again, as locked ones do."""
        self._session: Session | None = None
        self._nothing = QUndoStack(self)
        self._stroke: StrokeUnderWay | None = None
        self.past: Past | None = None
        """What the views show in place of the present depth."""
        self._watched: list[Session] = []
        """Frames with key frames, the one that was run last at the end."""

    @property
    def session(self) -> Session:
        """The present frame's session; only to be asked for while `has_session`."""
        if self._session is None:
            raise RuntimeError("no frame is open")
        return self._session

    @property
    def has_session(self) -> bool:
        """Whether a frame is open."""
        return self._session is not None

    @property
    def parameters(self) -> Parameters:
        """Parameters of all blocks of the present frame that have no values of their own."""
        return self.shared.values if self._session is None else self._session.common

    @property
    def next_parameters(self) -> Parameters:
        """What the next frame begins with."""
        return self.shared.values if self.shared.on else self.parameters

    def is_present(self, session: Session) -> bool:
        """Whether this is the present frame's session."""
        return session is self._session

    @property
    def chosen(self) -> int:
        """The block that edits and curves are about; 0 for none."""
        return self._session.selected[0] if self._session is not None and self._session.selected else 0

    def session_of(self, key: str) -> Session | None:
        """The open session of a file or folder, if there is one."""
        return next((session for session in self.sessions if session.key == key), None)

    def add_session(
        self, session: Session, recorded: Run | None = None, restored: bool = False, show: bool = True
    ) -> None:
        """Open a frame and, with `show`, make it the present one.

        It begins with the parameters of the present one, or of all, unless it is `restored`. With `recorded`, it comes
        from that run, and has the parameters of that; what it was extracted with goes for the next extraction, and the
        blocks that were run are chosen if they are not all.
        """
        if restored:
            self.shared.begin(session)
        else:
            session.take_common(self.next_parameters)
        if recorded is not None:
            self._take_recorded(session, recorded)
        self.sessions.append(session)
        listed = len(self.entries)
        self.entries.attach(session)
        self.undo_group.addStack(session.undo_stack)
        opened = ref(session)  # the history would hold the session, and never be freed
        session.undo_stack.indexChanged.connect(lambda _: self._note_step(opened()))
        self.sessions_changed.emit()
        if show:
            self.show_session(session)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def _take_recorded(self, session: Session, recorded: Run) -> None:
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
        """Make a frame the present one."""
        if session is self._session:
            return
        self._end_strokes()
        self.shared = Shared(self.shared.on, self.next_parameters)
        self._session = session
        self.undo_group.setActiveStack(session.undo_stack if session else self._nothing)
        self.session_changed.emit()

    def close_session(self, session: Session) -> None:
        """Close a frame for good; the one before it in the list becomes the present one."""
        entry = self.entries.of(session.id)
        self._leave(session)
        if entry is not None:
            self.remove_entries([entry])

    def put_away(self, session: Session, stored: bool = True) -> None:
        """Close a frame whose state is stored, or that has none: its entry stays, and it comes back as it was, without
        its history."""
        entry = self.entries.of(session.id)
        if entry is not None:
            self.entries.detach(entry, stored)
        self._leave(session)

    def add_entries(self, entries: Sequence[Entry]) -> None:
        """Add frames to the list without opening them."""
        self.entries.add(entries)
        self.project_touched.emit()

    def remove_entries(self, entries: Collection[Entry]) -> None:
        """Take frames out of the list, and close those that are open, for good."""
        gone = {entry.session for entry in entries if entry.session is not None}
        if self._session in gone:  # what is shown next is the nearest one that stays
            position = self.sessions.index(self._session)
            nearest = [*reversed(self.sessions[:position]), *self.sessions[position:]]
            self.show_session(next((session for session in nearest if session not in gone), None))
        for session in [session for session in self.sessions if session in gone]:
            self._leave(session)
        self.entries.remove(entries)
        self.project_touched.emit()

    def note_problem(self, entry: Entry, problem: str) -> None:
        """A frame of the list could not be opened, for this reason."""
        self.entries.note_problem(entry, problem)
        self.project_touched.emit()

    def _leave(self, session: Session) -> None:
        position = self.sessions.index(session)
        self.sessions.remove(session)
        self._watched = [one for one in self._watched if one is not session]
        if session is self._session:
            self.show_session(self.sessions[max(position - 1, 0)] if self.sessions else None)
        self.undo_group.removeStack(session.undo_stack)
        session.undo_stack.setParent(None)  # PySide takes it for the group's as long as that lives
        session.undo_stack.clear()  # commands and session hold each other, and would never be freed
        self.sessions_changed.emit()

    def note_saved(self, session: Session, stamp: tuple[int, int, int]) -> None:
        """What there was at a `Session.stamp` has been saved."""
        session.note_saved(stamp)
        self.sessions_changed.emit()

    def touch(self, session: Session, looked: bool = False) -> None:
        """Called after something has changed that a project holds; `looked`: only in how it is looked at, which is
        stored but no reason to save."""
        if not looked:
            session.note_other_change()
        if session in self.sessions:
            self.touched.emit(session)

    def _note_step(self, session: Session | None) -> None:
        """A step of a frame's history has been made, taken back or made again."""
        if session is not None and session in self.sessions:
            self.touched.emit(session)

    def set_note(self, entry: Entry, note: str) -> None:
        """What the user says of a frame, open or not."""
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
        """What blocks are extracted with the next time."""
        self.extraction_parameters = parameters
        self.extraction_changed.emit()
        self.project_touched.emit()

    # blocks that are chosen or painted

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke, which `end_stroke` makes a step and `drop_stroke` gives up."""
        if patch is None:
            return
        if self._stroke is None:
            self._stroke = StrokeUnderWay(self.session.labels)
        self._stroke.reach(patch.box)
        self.session.apply(patch)
        self.stroke_changed.emit(patch.box)

    @property
    def stroke_under_way(self) -> bool:
        """Whether the label map holds part of a stroke that may yet be given up."""
        return self._stroke is not None

    def drop_stroke(self) -> bool:
        """Put the pixels of the stroke back; False if none was under way."""
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
        """Choose blocks; the first is the one that edits and curves are about."""
        if self.has_session:
            self._select(self.session, labels)

    def _select(self, session: Session, labels: list[int]) -> None:
        if labels != session.selected:
            session.selected = labels
            if session is self._session:
                self.selection_changed.emit()

    # what commands say

    def prepare_change(self, session: Session) -> None:
        """Called before the label map of a session changes."""
        if session is self._session:
            self._end_strokes()

    def note_labels_changed(self, session: Session, patch: LabelPatch | None, change: Change | None = None) -> None:
        """Called by commands after the label map, or what is known of it, has changed; with `change`, by an edit."""
        if session is not self._session:
            self.sessions_changed.emit()
            return
        if patch is not None:
            left = session.counts()
            # a block that is yet to be painted has never been there
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
        """Called after results have come, gone or come back."""
        (self.results_changed if session is self._session else self.sessions_changed).emit()

    def note_distrusted_changed(self, session: Session) -> None:
        """Called by commands after other depth is distrusted."""
        if session is self._session:
            self.distrusted_changed.emit()
        self.note_results_changed(session)

    def note_guide_changed(self, session: Session) -> None:
        """Called by commands after another guide is followed."""
        if session is self._session:
            self.guide_changed.emit()
        self.note_results_changed(session)

    def note_checked(self, session: Session) -> None:
        """Called by commands after other blocks should be looked at."""
        self.note_infos_changed(session)
        self.sessions_changed.emit()

    def note_infos_changed(self, session: Session) -> None:
        """Called by commands after a name, colour or lock has changed."""
        if session is self._session:
            self.infos_changed.emit()
