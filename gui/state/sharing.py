"""Parameters shared by all frames or separate for each, and the undoable change between the two.

While they are shared, a change is one undo step of the frame where it was made. Undoing it restores the former values
in all frames, even if they were changed from another frame since: all frames without own parameters always have the
same ones.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, Protocol
from weakref import WeakKeyDictionary

from PySide6.QtGui import QUndoCommand

from ilf.data.parameters import Parameters

from .session import Session


class Shared(NamedTuple):
    """Whether parameters are shared by all frames, and the shared parameters."""

    on: bool
    values: Parameters
    """The next frame starts with these, whether they are shared or not."""

    def reach(self, session: Session) -> bool:
        """Whether a frame has the shared parameters."""
        return self.on and not session.own_parameters

    def begin(self, session: Session) -> None:
        """Set the shared parameters in a restored frame, unless it has its own."""
        if self.reach(session):
            session.take_common(self.values)

    def spread(self, sessions: Iterable[Session], passing: bool = False) -> None:
        """Set the shared parameters in all frames without own ones; with `passing`, undo does not lead back."""
        for session in sessions:
            if self.reach(session) and session.common != self.values:
                if not passing:
                    session.settle_parameters()
                session.take_common(self.values)


class ShareNotices(Protocol):
    """The object that applies a change of sharing."""

    @property
    def shared(self) -> Shared:
        """Whether parameters are shared, and which."""
        ...

    @property
    def sessions(self) -> list[Session]:
        """The open frames."""
        ...

    def touch(self, session: Session, looked: bool = False) -> None:
        """Note a change of project content; `looked`: it needs no saving."""
        ...

    def take_shared(self, shared: Shared, session: Session, common: Parameters, own: bool) -> None:
        """Set whether parameters are shared, the shared ones, and those of one frame."""
        ...


class ShareParameters(QUndoCommand):
    """A change of sharing: for all frames, or for one only. Undo restores the parameters of the other frames."""

    def __init__(self, notices: ShareNotices, session: Session, shared: Shared, own: bool, text: str) -> None:
        super().__init__(text)
        self._notices = notices
        self._session = session
        self._shared = shared
        self._common, self._own = session.common if own or not shared.on else shared.values, own
        self._former: WeakKeyDictionary[Session, Parameters] = WeakKeyDictionary()

    def redo(self) -> None:
        """Apply the change."""
        self._former = WeakKeyDictionary({session: session.common for session in self._notices.sessions})
        self._swap()
        self._note_parted()

    def undo(self) -> None:
        """Undo the change."""
        self._swap()
        if not self._notices.shared.on:
            there = self._notices.sessions
            for session, common in self._former.items():
                if session in there and session.common != common:
                    session.settle_parameters()
                    session.take_common(common)
        self._note_parted(looked=True)  # restoring an earlier state is no unsaved change

    def _note_parted(self, looked: bool = False) -> None:
        """Mark frames that no longer share parameters as changed: their parameters are now stored with them."""
        notices, was_shared = self._notices, self._shared.on
        for session in notices.sessions if was_shared and not notices.shared.on else ():
            if session is not self._session and not session.own_parameters:
                notices.touch(session, looked)

    def _swap(self) -> None:
        notices, session = self._notices, self._session
        before = notices.shared, session.common, session.own_parameters
        notices.take_shared(self._shared, session, self._common, self._own)
        self._shared, self._common, self._own = before
