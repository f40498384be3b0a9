"""How many frames stay open: those left longest ago are put away when their state is stored."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QSettings

from gui.state.session import Session
from gui.state.workspace import Workspace

MOST_OPEN = 8
_KEY = "frames/most_open"

Then = Callable[[Exception | None], None]


class OpenFrames(QObject):
    """Puts frames away, so that a long list can be worked through. They come back as they were, without their history.

    A frame is put away only if its state is stored as it is, or if nothing has been done to it; never while it is
    looked at, or runs.

    Parameters
    ----------
    workspace : Workspace
    is_busy : callable
        Whether anything is under way on a session.
    is_left : callable
        Whether a session was left before it even had blocks, so that there is nothing to store.
    is_stored : callable
        Whether a state of the frame of an id is stored.
    settle : callable
        Stores all that has changed, and then calls what it is given: with None if that has been done.
    """

    def __init__(
        self,
        workspace: Workspace,
        is_busy: Callable[[Session], bool],
        is_left: Callable[[Session], bool],
        is_stored: Callable[[str], bool],
        settle: Callable[[Then], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.most = max(int(str(QSettings().value(_KEY, MOST_OPEN, int))), 0) or MOST_OPEN
        self._workspace = workspace
        self._is_busy = is_busy
        self._is_left = is_left
        self._is_stored = is_stored
        self._settle = settle
        self._looked_at: list[Session] = []
        """The one that is looked at now comes last."""
        workspace.session_changed.connect(self._look)
        workspace.touched.connect(self._tidy_behind)
        workspace.sessions_changed.connect(self._forget_closed)

    def _forget_closed(self) -> None:
        self._looked_at = [session for session in self._looked_at if session in self._workspace.sessions]

    def _look(self) -> None:
        workspace = self._workspace
        if workspace.has_session:
            present = workspace.session
            self._looked_at = [*(one for one in self._looked_at if one is not present), present]
            self.tidy()

    def _tidy_behind(self, session: Session) -> None:
        """Work has been done on a frame that nobody has looked at, as where blocks are carried through a list."""
        if session not in self._looked_at and len(self._workspace.sessions) > self.most:
            self.tidy()

    def tidy(self) -> None:
        """Put away what is too much, as far as it may be."""
        for session in self._too_many():
            if self._is_left(session) and not session.unsaved and not session.counts():
                self._workspace.put_away(session, stored=False)
        going = [(session, session.stamp) for session in self._too_many()]
        if going:
            self._settle(lambda error: self._put_away(going) if error is None else None)

    def _too_many(self) -> list[Session]:
        """Frames beyond those that may stay open, the one left longest ago first."""
        sessions = self._workspace.sessions
        never = [session for session in sessions if session not in self._looked_at]
        idle = [
            session
            for session in (*never, *self._looked_at)
            if session in sessions and not self._workspace.is_present(session) and not self._is_busy(session)
        ]
        return idle[: max(len(sessions) - self.most, 0)]

    def _put_away(self, going: Sequence[tuple[Session, tuple[int, ...]]]) -> None:
        """These frames are stored as they were; those that have not changed since can go."""
        still = self._too_many()
        for session, stamp in going:
            if session in still and session.stamp == stamp and self._is_stored(session.id):
                self._workspace.put_away(session)
