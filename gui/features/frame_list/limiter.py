"""How many frames stay open: the least recently shown ones are closed once their state is stored."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject

from ...state.document import Document
from ...state.parts import Part
from ..context import Context


class OpenFrameLimiter(QObject):
    """Closes frames to limit the memory for long lists. They are reopened in the same state, without undo history.

    A frame is closed only if its current state is stored, or if nothing has been done to it; never while it is shown
    or running.
    """

    max_open = 8

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self._context, self._workspace = context, context.workspace
        self._recently_shown: list[Document] = []
        """In the order in which they were shown; the current one is the last."""
        context.workspace.on(Part.FRAME | Part.LIST, self._tidy)

    def _tidy(self) -> None:
        """Note which frame is shown, and forget closed ones. Close surplus frames after another one is shown, and after
        work on frames that were never shown, such as propagation through a list."""
        documents, before = self._workspace.open, self._recently_shown
        present = [self._workspace.current] if self._workspace.shown is not None else []
        self._recently_shown = [*(one for one in before if one in documents and one not in present), *present]
        if before[-1:] != present or len(documents) > max(self.max_open, len(self._recently_shown)):
            self.close_surplus()

    def close_surplus(self) -> None:
        """Close surplus frames as far as possible."""
        going = [(document, document.stamp) for document in self._surplus()]
        if going:
            self._context.recorder.flush(lambda error: self._put_away(going) if error is None else None)

    def is_busy(self, document: Document) -> bool:
        """Whether work on a frame is in progress."""
        context = self._context
        return (
            document in context.runs.running
            or document in context.loader.extracting
            or any(way.about is document for way in context.pending_work())
        )

    def _surplus(self) -> list[Document]:
        """Return the frames beyond the maximum number, the least recently shown first."""
        documents = self._workspace.open
        never = [document for document in documents if document not in self._recently_shown]
        idle = [
            document
            for document in (*never, *self._recently_shown)
            if document in documents and document is not self._workspace.shown and not self.is_busy(document)
        ]
        return idle[: max(len(documents) - self.max_open, 0)]

    def _put_away(self, going: Sequence[tuple[Document, tuple[int, ...]]]) -> None:
        """Close the stored frames that have not changed since."""
        still = self._surplus()
        for document, stamp in going:
            if document in still and document.stamp == stamp and self._context.recorder.store.has(document.id):
                self._workspace.unload(document)
