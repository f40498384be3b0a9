"""How many frames stay open: the least recently shown ones are closed once their state is stored."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QSettings

from ...state.document import Document
from ...state.parts import Part
from ...state.workspace import Workspace

MAX_OPEN_FRAMES = 8
_KEY = "frames/most_open"

Then = Callable[[Exception | None], None]


class OpenFrameLimiter(QObject):
    """Closes frames to limit the memory for long lists. They are reopened in the same state, without undo history.

    A frame is closed only if its current state is stored, or if nothing has been done to it; never while it is shown
    or running.

    Parameters
    ----------
    workspace : Workspace
    is_busy : callable
        Returns whether work on a document is in progress.
    is_left : callable
        Returns whether another frame was shown before a document had blocks, so that there is nothing to store.
    is_stored : callable
        Returns whether a state of the frame with an id is stored.
    flush : callable
        Stores all changes, then calls its argument: with None on success, or with the exception.
    """

    def __init__(
        self,
        workspace: Workspace,
        is_busy: Callable[[Document], bool],
        is_left: Callable[[Document], bool],
        is_stored: Callable[[str], bool],
        flush: Callable[[Then], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.max_open = max(int(str(QSettings().value(_KEY, MAX_OPEN_FRAMES, int))), 0) or MAX_OPEN_FRAMES
        self._workspace = workspace
        self._is_busy = is_busy
        self._is_left = is_left
        self._is_stored = is_stored
        self._settle = flush
        self._recently_shown: list[Document] = []
        """In the order in which they were shown; the current one is the last."""
        workspace.on(Part.FRAME | Part.LIST, self._tidy)

    def _tidy(self) -> None:
        """Note which frame is shown, and forget closed ones. Close surplus frames after another one is shown, and after
        work on frames that were never shown, such as propagation through a list."""
        documents, before = self._workspace.open, self._recently_shown
        present = [self._workspace.current] if self._workspace.has_current else []
        self._recently_shown = [*(one for one in before if one in documents and one not in present), *present]
        if before[-1:] != present or len(documents) > max(self.max_open, len(self._recently_shown)):
            self.close_surplus()

    def close_surplus(self) -> None:
        """Close surplus frames as far as possible."""
        for document in self._surplus():
            if self._is_left(document) and not document.unsaved and not document.counts():
                self._workspace.unload(document, stored=False)
        going = [(document, document.stamp) for document in self._surplus()]
        if going:
            self._settle(lambda error: self._put_away(going) if error is None else None)

    def _surplus(self) -> list[Document]:
        """Return the frames beyond the maximum number, the least recently shown first."""
        documents = self._workspace.open
        never = [document for document in documents if document not in self._recently_shown]
        idle = [
            document
            for document in (*never, *self._recently_shown)
            if document in documents and not self._workspace.is_shown(document) and not self._is_busy(document)
        ]
        return idle[: max(len(documents) - self.max_open, 0)]

    def _put_away(self, going: Sequence[tuple[Document, tuple[int, ...]]]) -> None:
        """Close the stored frames that have not changed since."""
        still = self._surplus()
        for document, stamp in going:
            if document in still and document.stamp == stamp and self._is_stored(document.id):
                self._workspace.unload(document)
