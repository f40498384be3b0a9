"""Doing without a user what one would do: open, run, take a picture, exit."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from gui.dialogs.documents import Documents
from gui.frames.loader import FrameLoader
from gui.state.workspace import Workspace
from gui.work.runs import RunController

_SETTLE_MS = 400


class Unattended(QObject):
    """Waits for the frame, runs it if asked, saves a picture and quits if asked.

    `status` is the exit status: 1 if something failed on the way.
    """

    def __init__(
        self,
        workspace: Workspace,
        loader: FrameLoader,
        runs: RunController,
        documents: Documents,
        close: Callable[[], object],
        run: bool,
        picture: str | None,
    ) -> None:
        super().__init__(documents)
        self._workspace = workspace
        self._loader = loader
        self._runs = runs
        self._documents = documents
        self._close = close
        self._run = run
        self._picture = picture
        self.status = 0
        loader.failed.connect(self._note_failure)
        runs.failed.connect(self._note_failure)

    def start(self) -> None:
        """Go on as soon as every frame is open."""
        if self._loader.busy:
            self._loader.idle.connect(self._opened)
        else:
            self._opened()

    def _opened(self) -> None:
        if self._run and self._workspace.has_session and self._workspace.session.counts():
            self._runs.ended.connect(lambda _: self._finish())
            self._runs.start()
        else:
            self._finish()

    def _finish(self) -> None:
        if self._picture is not None:
            QTimer.singleShot(_SETTLE_MS, self, self._take_picture)

    def _take_picture(self) -> None:
        if not self._documents.save_picture(self._picture or ""):
            self.status = 1
        self._documents.discard_silently = True
        self._close()
        QApplication.quit()

    def _note_failure(self, *_: object) -> None:
        self.status = 1
