"""Undoable commands on blocks that come from another frame: to take them, and to have looked at them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Protocol

from PySide6.QtGui import QUndoCommand

from gui.state.commands import Notices
from gui.state.session import Session
from ilf.ebs.edit import patch_between
from ilf.parameters import Parameters
from ilf.project import FrameState


class CarryNotices(Notices, Protocol):
    """Who is told, also of common parameters and of what should be looked at."""

    def take_common(self, session: Session, common: Parameters, own: bool) -> None:
        """Other common parameters of a frame; `own`: they are its own where parameters are for all frames."""
        ...

    def note_checked(self, session: Session) -> None:
        """Other blocks should be looked at."""
        ...


class CarryBlocks(QUndoCommand):
    """A frame takes the blocks that were carried to it, with all that is known of them and the values of their runs."""

    def __init__(self, notices: CarryNotices, session: Session, carried: FrameState, text: str) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._patch = patch_between(session.labels, carried.labels)
        notes = carried.notes
        self._notes = replace(notes, infos=dict(notes.infos), own=dict(notes.own))
        self._common, self._own, self._dense = carried.common, carried.own_parameters, carried.dense
        self._to_check = set(carried.to_check)

    def redo(self) -> None:
        """Make the change."""
        self._swap(forward=True)

    def undo(self) -> None:
        """Take it back."""
        self._swap(forward=False)

    def _swap(self, forward: bool) -> None:
        session = self._session
        self._notices.prepare_change(session)
        if self._patch is not None:
            session.apply(self._patch, forward)
        self._notes = session.take_notes(self._notes)
        session.to_check, self._to_check = self._to_check, session.to_check
        session.dense, self._dense = self._dense, session.dense
        common, own = session.common, session.own_parameters
        self._notices.take_common(session, self._common, self._own)
        self._common, self._own = common, own
        self._notices.note_checked(session)
        self._notices.note_labels_changed(session, self._patch)


class LookAtBlocks(QUndoCommand):
    """Blocks that needed a look have been looked at."""

    def __init__(self, notices: CarryNotices, session: Session, blocks: Collection[int]) -> None:
        name = session.info(next(iter(blocks))).name if len(blocks) == 1 else f"{len(blocks)} blocks"
        super().__init__(f"Looked at {name}")
        self._notices = notices
        self._session = session
        self._blocks = frozenset(blocks)

    def redo(self) -> None:
        """Make the change."""
        self._session.to_check = self._session.to_check - self._blocks
        self._notices.note_checked(self._session)

    def undo(self) -> None:
        """Take it back."""
        self._session.to_check = self._session.to_check | self._blocks
        self._notices.note_checked(self._session)
