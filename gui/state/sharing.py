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


class SharedParameters(NamedTuple):
    """Whether parameters are shared by all frames, and the shared parameters."""

    on: bool
    values: Parameters
    """The next frame starts with these, whether they are shared or not."""

    def applies_to(self, session: Session) -> bool:
        """Whether a frame has the shared parameters."""
        return self.on and not session.own_parameters

    def apply_to(self, session: Session) -> None:
        """Set the shared parameters in a restored frame, unless it has its own."""
        if self.applies_to(session):
            session.take_common(self.values)

    def apply_to_all(self, sessions: Iterable[Session], transient: bool = False) -> None:
        """Set the shared parameters in all frames without own ones; with `transient`, undo does not lead back."""
        for session in sessions:
            if self.applies_to(session) and session.common != self.values:
                if not transient:
                    session.remember_parameters()
                session.take_common(self.values)


class SharingHost(Protocol):
    """The object that applies a change of sharing."""

    @property
    def shared(self) -> SharedParameters:
        """Whether parameters are shared, and which."""
        ...

    @property
    def sessions(self) -> list[Session]:
        """The open frames."""
        ...

    def touch(self, session: Session, viewing: bool = False) -> None:
        """Note a change of project content; `viewing`: it needs no saving."""
        ...

    def take_shared(self, shared: SharedParameters, session: Session, common: Parameters, own: bool) -> None:
        """Set whether parameters are shared, the shared ones, and those of one frame."""
        ...


class ShareParameters(QUndoCommand):
    """A change of sharing: for all frames, or for one only. Undo restores the parameters of the other frames."""

    def __init__(self, host: SharingHost, session: Session, shared: SharedParameters, own: bool, text: str) -> None:
        super().__init__(text)
        self._host = host
        self._session = session
        self._shared = shared
        self._common, self._own = session.common if own or not shared.on else shared.values, own
        self._former: WeakKeyDictionary[Session, Parameters] = WeakKeyDictionary()

    def redo(self) -> None:
        """Apply the change."""
        self._former = WeakKeyDictionary({session: session.common for session in self._host.sessions})
        self._swap()
        self._mark_separated()

    def undo(self) -> None:
        """Undo the change."""
        self._swap()
        if not self._host.shared.on:
            there = self._host.sessions
            for session, common in self._former.items():
                if session in there and session.common != common:
                    session.remember_parameters()
                    session.take_common(common)
        self._mark_separated(viewing=True)  # restoring an earlier state is no unsaved change

    def _mark_separated(self, viewing: bool = False) -> None:
        """Mark frames that no longer share parameters as changed: their parameters are now stored with them."""
        host, was_shared = self._host, self._shared.on
        for session in host.sessions if was_shared and not host.shared.on else ():
            if session is not self._session and not session.own_parameters:
                host.touch(session, viewing)

    def _swap(self) -> None:
        host, session = self._host, self._session
        before = host.shared, session.common, session.own_parameters
        host.take_shared(self._shared, session, self._common, self._own)
        self._shared, self._common, self._own = before
