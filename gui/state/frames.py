"""The frames of the window, open or not, and the current one. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup, QUndoStack

from .document import Document
from .entries import Entries, Entry
from .parts import Changes, Part


class Frames(Changes):
    """The frames, open or not, which one is the current one, and which have changed since they were saved.

    Attributes
    ----------
    open : list of Document
    entries : Entries
        All frames, open or not.
    undo_group : QUndoGroup
        The undo histories of all documents; that of the current one is the active one.

    Signals
    -------
    project_touched()
        Content of the project apart from its frames has changed: the list and its order, shared settings.
    """

    project_touched = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.open: list[Document] = []
        self.entries = Entries()
        self.undo_group = QUndoGroup(self)
        self._empty_stack = QUndoStack(self)

    @property
    def current(self) -> Document:
        """The document that is shown; only valid while `has_current`."""
        if self._shown is None:
            raise RuntimeError("no frame is open")
        document: Document = self._shown
        return document

    @property
    def has_current(self) -> bool:
        """Whether a frame is open."""
        return self._shown is not None

    @property
    def current_entry(self) -> Entry | None:
        """The entry of the current document; None if no frame is open."""
        return None if self._shown is None else self.entries.of(self._shown.id)

    @property
    def chosen(self) -> int:
        """The first selected block of the current document; 0 for none."""
        return self.current.chosen if self.has_current else 0

    def select(self, labels: Sequence[int]) -> None:
        """Select blocks of the current document, if there is one."""
        if self.has_current:
            self.current.select(labels)

    @property
    def stroke_in_progress(self) -> bool:
        """Whether a stroke is in progress."""
        return self.has_current and self.current.stroke_in_progress

    def end_stroke(self) -> None:
        """Drop a stroke in progress, before all is stored."""
        if self.stroke_in_progress:
            self.current.prepare_change()

    def touch_project(self, part: Part) -> None:
        """Tell of a change of the project apart from its frames."""
        self.note(part)
        self.project_touched.emit()

    def document_of(self, key: str) -> Document | None:
        """Return the open document of a file or folder; None if there is none."""
        return next((document for document in self.open if document.key == key), None)

    def add(self, document: Document, show: bool = True) -> None:
        """Add an open frame that has its parameters and, with `show`, make it the current one."""
        self.open.append(document)
        document.changes = self
        listed = len(self.entries)
        self.entries.attach(document)
        self.undo_group.addStack(document.undo_stack)
        self.note(Part.LIST)
        if show:
            self.show(document)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def show(self, document: Document | None) -> None:
        """Make a frame the current one."""
        if document is self._shown:
            return
        if self._shown is not None:
            self._shown.prepare_change()
        self._shown = document
        self.undo_group.setActiveStack(document.undo_stack if document else self._empty_stack)
        self.note(Part.FRAME)

    def unload(self, document: Document, stored: bool = True) -> None:
        """Close a frame whose state is stored, or that has none; its entry stays, and it can be opened again in the
        same state, without its undo history."""
        entry = self.entries.of(document.id)
        if entry is not None:
            self.entries.detach(entry, stored)
        self._close(document)

    def add_entries(self, entries: Sequence[Entry]) -> None:
        """Add frames to the list without opening them."""
        self.entries.add(entries)
        self.touch_project(Part.LIST)

    def remove_entries(self, entries: Collection[Entry]) -> None:
        """Remove frames from the list permanently, and close those that are open."""
        gone = {entry.document for entry in entries if entry.document is not None}
        if self._shown in gone:  # show the nearest remaining frame
            position = self.open.index(self._shown)
            nearest = [*reversed(self.open[:position]), *self.open[position:]]
            self.show(next((document for document in nearest if document not in gone), None))
        for document in [document for document in self.open if document in gone]:
            self._close(document)
        self.entries.remove(entries)
        self.touch_project(Part.LIST)

    def note_problem(self, entry: Entry, problem: str) -> None:
        """Store why a frame of the list could not be opened."""
        entry.problem = problem
        self.note(Part.LIST)

    def _close(self, document: Document) -> None:
        position = self.open.index(document)
        self.open.remove(document)
        if document is self._shown:
            self.show(self.open[max(position - 1, 0)] if self.open else None)
        document.changes = Changes()
        self.undo_group.removeStack(document.undo_stack)
        document.undo_stack.setParent(None)  # PySide treats it as owned by the group while the group exists
        document.undo_stack.clear()  # commands and document reference each other and would never be freed
        self.note(Part.LIST)

    def set_note(self, entry: Entry, note: str) -> None:
        """Set the user's note on a frame, open or not."""
        self._mark(entry, note, entry.summary.done)

    def set_done(self, entry: Entry, done: bool) -> None:
        """Set whether the user has marked a frame as done, open or not."""
        self._mark(entry, entry.note, done)

    def _mark(self, entry: Entry, note: str, done: bool) -> None:
        if (note, done) == (entry.note, entry.summary.done):
            return
        if entry.document is None:
            entry.set_unsaved(True)
            entry.set_summary(replace(entry.stored_summary, note=note, done=done))
        else:
            entry.document.change(note=note, done=done)
            entry.document.touch()
        self.touch_project(Part.LIST)
