"""Frames of the workspace and the current frame. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from weakref import ref

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup, QUndoStack

from .entries import Entries, Entry
from .session import Session


class WorkspaceFrames(QObject):
    """The frames, open or not, which one is the current one, and which have changed since they were saved.

    Signals carry no data that could go stale: listeners read the workspace. In all parts of the workspace, signals
    about a session are emitted for the current frame only; for other frames, `sessions_changed` is.
    """

    sessions_changed = Signal()
    """Frames were opened or closed, or their summaries in the list changed."""
    leaving = Signal()
    """Another frame is about to become the current one."""
    session_changed = Signal()
    """Another frame is the current one."""
    touched = Signal(object)
    """Content of a Session, current or not, that a project stores has changed."""
    project_touched = Signal()
    """Content of the project apart from its frames has changed: the list and its order, shared settings."""

    def __init__(self, undo_group: QUndoGroup, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sessions: list[Session] = []
        """The frames that are open."""
        self.entries = Entries(self)
        """All frames, open or not."""
        self._undo_group = undo_group
        self._session: Session | None = None
        self._empty_stack = QUndoStack(self)

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

    def is_current(self, session: Session) -> bool:
        """Whether this is the current frame's session."""
        return session is self._session

    def session_of(self, key: str) -> Session | None:
        """Return the open session of a file or folder; None if there is none."""
        return next((session for session in self.sessions if session.key == key), None)

    def add(self, session: Session, show: bool = True) -> None:
        """Add an open frame that has its parameters and, with `show`, make it the current one."""
        self.sessions.append(session)
        listed = len(self.entries)
        self.entries.attach(session)
        self._undo_group.addStack(session.undo_stack)
        opened = ref(session)  # a strong reference would keep the session alive through its history
        session.undo_stack.indexChanged.connect(lambda _: self._note_step(opened()))
        self.sessions_changed.emit()
        if show:
            self.show(session)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def show(self, session: Session | None) -> None:
        """Make a frame the current one."""
        if session is self._session:
            return
        self.leaving.emit()
        self._session = session
        self._undo_group.setActiveStack(session.undo_stack if session else self._empty_stack)
        self.session_changed.emit()

    def close(self, session: Session) -> None:
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
            self.show(next((session for session in nearest if session not in gone), None))
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
        if session is self._session:
            self.show(self.sessions[max(position - 1, 0)] if self.sessions else None)
        self._undo_group.removeStack(session.undo_stack)
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
        self._mark(entry, note, entry.summary.done)

    def set_done(self, entry: Entry, done: bool) -> None:
        """Set whether the user has marked a frame as done, open or not."""
        self._mark(entry, entry.note, done)

    def _mark(self, entry: Entry, note: str, done: bool) -> None:
        if (note, done) == (entry.note, entry.summary.done):
            return
        if entry.session is None:
            self.entries.mark(entry, note, done)
        else:
            entry.session.change(note=note, done=done)
            self.touch(entry.session)
        self.sessions_changed.emit()
        self.project_touched.emit()
