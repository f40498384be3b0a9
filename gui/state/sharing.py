"""Parameters for all frames, or for this one: which they are, and the undoable step from one to the other.

While they are for all, a change is one step in the history of the frame where it was made. To undo it puts back what
that step replaced, in all frames, whatever has been set in others since: a frame's undo does what its text says, and
all frames without their own values have the same ones at any time.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Protocol
from weakref import WeakKeyDictionary

from PySide6.QtGui import QUndoCommand

from ilf.data.parameters import Parameters

from .session import Session


class Shared(NamedTuple):
    """Whether parameters are for all frames, and what frames have that have none of their own."""

    on: bool
    values: Parameters
    """What the next frame begins with, in any case."""

    def reach(self, session: Session) -> bool:
        """Whether a frame has the values of all."""
        return self.on and not session.own_parameters

    def begin(self, session: Session) -> None:
        """A frame is opened as it was stored: it has the values of all, unless it has its own."""
        if self.reach(session):
            session.take_common(self.values)

    def spread(self, sessions: Iterable[Session], passing: bool = False) -> None:
        """Have the values in all frames without their own; with `passing`, no undo leads back to what they had."""
        for session in sessions:
            if self.reach(session) and session.common != self.values:
                if not passing:
                    session.settle_parameters()
                session.take_common(self.values)


class ShareNotices(Protocol):
    """Who carries a change out."""

    @property
    def shared(self) -> Shared:
        """Whether parameters are for all frames."""
        ...

    @property
    def sessions(self) -> list[Session]:
        """The frames that are open."""
        ...

    def touch(self, session: Session, looked: bool = False) -> None:
        """Something has changed that a project holds; `looked`: no reason to save."""
        ...

    def take_shared(self, shared: Shared, session: Session, common: Parameters, own: bool) -> None:
        """Whether parameters are for all frames, which those are, and those of one frame."""
        ...


class ShareParameters(QUndoCommand):
    """Parameters are for all frames from now on, or for one alone. Undo gives the others back what they had."""

    def __init__(self, notices: ShareNotices, session: Session, shared: Shared, own: bool, text: str) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._shared = shared
        self._common, self._own = session.common if own or not shared.on else shared.values, own
        self._former: WeakKeyDictionary[Session, Parameters] = WeakKeyDictionary()

    def redo(self) -> None:
        """Make the change."""
        self._former = WeakKeyDictionary({session: session.common for session in self._notices.sessions})
        self._swap()
        self._note_parted()

    def undo(self) -> None:
        """Take it back."""
        self._swap()
        if not self._notices.shared.on:
            there = self._notices.sessions
            for session, common in self._former.items():
                if session in there and session.common != common:
                    session.settle_parameters()
                    session.take_common(common)
        self._note_parted(looked=True)  # to come back to what was there before is no work

    def _note_parted(self, looked: bool = False) -> None:
        """Frames have no longer the values of all, but those that they have by now: these must be stored with them."""
        notices, was_shared = self._notices, self._shared.on
        for session in notices.sessions if was_shared and not notices.shared.on else ():
            if session is not self._session and not session.own_parameters:
                notices.touch(session, looked)

    def _swap(self) -> None:
        notices, session = self._notices, self._session
        before = notices.shared, session.common, session.own_parameters
        notices.take_shared(self._shared, session, self._common, self._own)
        self._shared, self._common, self._own = before
