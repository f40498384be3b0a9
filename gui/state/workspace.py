"""What the window works on: the open frames, the present one, the parameters. Signals, no widgets."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup

from gui.state.commands import EditInfo, EditLabels
from gui.state.session import BlockNotes, Session
from ilf.completion import BlockResult
from ilf.ebs.edit import LabelPatch, patch_between
from ilf.ebs.reextraction import flow_around, keep_under
from ilf.parameters import DEFAULT_PRESET, BlockParameters, Parameters, preset


class Kept(NamedTuple):
    """How many blocks stayed as they were when blocks were extracted again, and whether there are no others."""

    locked: int
    by_hand: int
    all_of_them: bool


class Workspace(QObject):
    """The single place where the state of the window changes.

    Signals carry no data that could go stale: who listens reads the workspace.
    """

    about_to_change = Signal()
    """The present frame is about to be left, or its label map to be changed: strokes under way must end."""
    sessions_changed = Signal()
    """Frames were opened or closed, or what the list says of them has changed."""
    session_changed = Signal()
    labels_changed = Signal(object)
    """The box (rows, columns) of the label map that changed, or None for all of it."""
    infos_changed = Signal()
    results_changed = Signal()
    selection_changed = Signal()
    parameters_changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.sessions: list[Session] = []
        self.undo_group = QUndoGroup(self)
        self.parameters: Parameters = preset(DEFAULT_PRESET)
        self.extraction_parameters = BlockParameters()
        self.keeps_handmade = True
        """Whether blocks that were made by hand stay when blocks are extracted again, as locked ones do."""
        self._session: Session | None = None

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

    def session_of(self, key: str) -> Session | None:
        """The open session of a file or folder, if there is one."""
        return next((session for session in self.sessions if session.key == key), None)

    def add_session(self, session: Session) -> None:
        """Open a frame and make it the present one."""
        self.sessions.append(session)
        self.undo_group.addStack(session.undo_stack)
        self.sessions_changed.emit()
        self.show_session(session)

    def show_session(self, session: Session | None) -> None:
        """Make a frame the present one."""
        if session is self._session:
            return
        self.about_to_change.emit()
        self._session = session
        self.undo_group.setActiveStack(session.undo_stack if session else None)
        self.session_changed.emit()

    def close_session(self, session: Session) -> None:
        """Close a frame; the one before it in the list becomes the present one."""
        position = self.sessions.index(session)
        self.sessions.remove(session)
        if session is self._session:
            self.show_session(self.sessions[max(position - 1, 0)] if self.sessions else None)
        self.undo_group.removeStack(session.undo_stack)
        session.undo_stack.clear()  # commands and session hold each other, and would never be freed
        self.sessions_changed.emit()

    def set_extracted(self, session: Session, labels: NDArray[np.int32], used: BlockParameters) -> Kept:
        """Take the blocks of another extraction as one undoable step, around the blocks that stay as they are."""
        self.prepare_change(session)
        locked, by_hand = self.staying(session)
        kept, handmade = locked | by_hand, session.handmade()
        around = flow_around(session.labels, kept, labels, used.min_size / 100 * labels.size)
        # a block that only was locked is not made by hand: it goes when it is unlocked
        self._replace(session, around, "Extract blocks", BlockNotes({}, {}, used, around.copy(), kept, handmade & kept))
        return Kept(len(locked), len(by_hand), kept == set(session.counts()))

    def staying(self, session: Session) -> tuple[frozenset[int], frozenset[int]]:
        """Blocks that stay when blocks are extracted again: locked ones, and others made by hand."""
        locked = session.locked & set(session.counts())
        return locked, session.handmade() - locked if self.keeps_handmade else frozenset()

    def replace_labels(self, labels: NDArray[np.int32], text: str) -> None:
        """Take another label map for the present frame as one undoable step; locked blocks stay."""
        session = self.session
        self.prepare_change(session)
        locked = session.locked
        self._replace(session, keep_under(session.labels, locked, labels), text, BlockNotes(kept=locked))

    def _replace(self, session: Session, labels: NDArray[np.int32], text: str, notes: BlockNotes) -> None:
        """Take another map and what is known of it; of the blocks that it keeps, what was known of them."""
        old, patch = session.notes, patch_between(session.labels, labels)
        if patch is None:
            session.notes = replace(notes, infos=old.infos, parameters=old.parameters)
            return
        notes.infos = {label: info for label, info in old.infos.items() if label in notes.kept}
        notes.parameters = {label: own for label, own in old.parameters.items() if label in notes.kept}
        session.undo_stack.push(EditLabels(self, session, patch, text, notes=notes))

    def edit_labels(self, patch: LabelPatch | None, text: str, done: bool = False) -> bool:
        """Change the label map as one undoable step; False if there is nothing to change."""
        if patch is None:
            return False
        self.session.undo_stack.push(EditLabels(self, self.session, patch, text, done))
        return True

    def edit_info(self, label: int, text: str, **changes: object) -> None:
        """Rename, recolour or lock a block as one undoable step."""
        self.session.undo_stack.push(EditInfo(self, self.session, label, text, **changes))

    def set_visible(self, label: int, visible: bool) -> None:
        """Show or hide a block in the overlay. A matter of view, so not undoable."""
        self.session.change_info(label, visible=visible)
        self.infos_changed.emit()

    def select(self, labels: list[int]) -> None:
        """Choose blocks; the first is the one that edits and curves are about."""
        if self.has_session and labels != self.session.selected:
            self.session.selected = labels
            self.selection_changed.emit()

    def store_results(self, session: Session, results: list[BlockResult]) -> None:
        """Keep blocks' results."""
        session.add_results(results)
        if session is self._session:
            self.results_changed.emit()
        else:
            self.sessions_changed.emit()

    def clear_results(self) -> None:
        """Forget all results of the present frame."""
        self.session.clear_results()
        self.results_changed.emit()

    def set_parameters(self, parameters: Parameters, label: int | None = None) -> None:
        """Parameters of all blocks, or of one; a block whose own equal the common ones has none of its own."""
        if label is None:
            self.parameters = parameters
        elif parameters == self.parameters:
            self.session.notes.parameters.pop(label, None)
        else:
            self.session.notes.parameters[label] = parameters
        self.parameters_changed.emit()

    def prepare_change(self, session: Session) -> None:
        """Called before the label map of a session changes."""
        if session is self._session:
            self.about_to_change.emit()

    def note_labels_changed(self, session: Session, patch: LabelPatch) -> None:
        """Called by commands after the label map has changed."""
        if session is not self._session:
            return
        left = session.counts()
        # a block that is yet to be painted has never been there
        gone = [
            label
            for label in session.selected
            if label not in left and ((patch.before == label).any() or (patch.after == label).any())
        ]
        self.labels_changed.emit(patch.box)
        self.results_changed.emit()
        if gone:
            self.select([label for label in session.selected if label not in gone])

    def note_infos_changed(self, session: Session) -> None:
        """Called by commands after a name, colour or lock has changed."""
        if session is self._session:
            self.infos_changed.emit()
