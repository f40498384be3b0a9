"""Doing without a user what one would do: open, run, take a picture, exit."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from gui.main_window import MainWindow

_SETTLE_MS = 400


class Unattended(QObject):
    """Waits for the frame, runs it if asked, saves a picture and quits if asked.

    `status` is the exit status: 1 if something failed on the way.
    """

    def __init__(self, window: MainWindow, run: bool, picture: str | None) -> None:
        super().__init__(window)
        self._window = window
        self._run = run
        self._picture = picture
        self.status = 0
        window.loader.failed.connect(self._note_failure)
        window.runs.failed.connect(self._note_failure)

    def start(self) -> None:
        """Go on as soon as every frame is open."""
        if self._window.loader.busy:
            self._window.loader.idle.connect(self._opened)
        else:
            self._opened()

    def _opened(self) -> None:
        if self._run and self._window.workspace.has_session and self._window.actions_["run"].isEnabled():
            self._window.runs.ended.connect(lambda _: self._finish())
            self._window.runs.start()
        else:
            self._finish()

    def _finish(self) -> None:
        if self._picture is not None:
            QTimer.singleShot(_SETTLE_MS, self, self._take_picture)

    def _take_picture(self) -> None:
        if not self._window.documents.save_picture(self._picture or ""):
            self.status = 1
        self._window.documents.discard_silently = True
        self._window.close()
        QApplication.quit()

    def _note_failure(self, *_: object) -> None:
        self.status = 1
