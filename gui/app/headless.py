"""Headless use of the window: open, run, save a screenshot, exit."""

from __future__ import annotations

import sys

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtWidgets import QApplication

from ilf.data.results import Status

from ..features.expected_error import ErrorFeature
from .main_window import MainWindow

_SETTLE_MS = 400


class HeadlessRun(QObject):
    """Waits for the frame, runs it on request, and on request saves a screenshot and quits.

    Any error is printed as one line on stderr and sets `status`, the exit status, to 1. Then nothing more is run and
    no screenshot is saved.
    """

    def __init__(self, window: MainWindow, run: bool, picture: str | None) -> None:
        super().__init__(window)
        self._window = window
        self._run = run
        self._picture = picture
        self.status = 0
        # no user can confirm the loss of work
        window.project.discard_silently = picture is not None
        window.notes.reported.connect(self.note_failure)

    def start(self) -> None:
        """Continue as soon as every frame is open."""
        if self._window.loader.busy:
            self._window.loader.idle.connect(self._opened, Qt.ConnectionType.SingleShotConnection)
        else:
            self._opened()

    def note_failure(self, what: str) -> None:
        """Print an error in one line."""
        self.status = 1
        print("ilf-gui: error:", " ".join(what.split()), file=sys.stderr, flush=True)

    def stop(self, what: str) -> None:
        """Stop because of an error."""
        self.note_failure(what)
        self.finish()

    def _opened(self) -> None:
        workspace = self._window.workspace
        if not self.status and not workspace.has_current and self._picture is not None:
            self._stop_without_frame()
        elif self.status or not self._run:
            self.finish()
        elif not workspace.has_current:
            return  # the user can open one
        elif not workspace.current.counts():
            self.stop(
                f"{workspace.current.name} has no blocks to complete: "
                "draw blocks in the window, or extract them with other parameters."
            )
        else:
            self._await_end()
            self._window.runs.current.start()

    def _stop_without_frame(self) -> None:
        """Stop if a frame could not be opened, or is needed."""
        entries = self._window.workspace.entries
        problems = [f"{entry.name}: {entry.summary.problem}" for entry in entries if entry.summary.problem]
        if problems:
            self.stop(problems[0])
        elif self._run:
            self.stop("There is no frame to run: give a frame folder, or a colour file and its depth file.")
        else:
            self.finish()

    def _await_end(self) -> None:
        # one event loop turn later: after a run, an extrapolation may start
        self._window.runs.ended.connect(
            lambda _: QTimer.singleShot(0, self, self._ran), Qt.ConnectionType.SingleShotConnection
        )

    def _ran(self) -> None:
        if not self._window.runs.state.free:
            self._await_end()
            return
        document = self._window.workspace.current
        results = document.valid_results().values()
        if results and all(result.outcome.status is Status.NOT_RECOVERABLE for result in results):
            reason = next(iter(results)).outcome.message
            self.note_failure(f"{document.name}: no block could be completed. First block: {reason}")
        self.finish()

    def finish(self) -> None:
        """Save the screenshot if there was no error, and quit; without a screenshot, leave the window to the user."""
        if self._picture is not None:
            QTimer.singleShot(_SETTLE_MS, self, self._take_picture)

    def _take_picture(self) -> None:
        # the expected error, if it is shown, is computed after the run
        if not self.status and self._window.feature(ErrorFeature).busy:
            self.finish()
            return
        if not self.status and not self._window.documents.picture().save(self._picture or "", "PNG"):
            self.note_failure(f"{self._picture} could not be written. Use another folder, or free disk space.")
        # closing the last window would quit a second time and end the next event loop
        QApplication.setQuitOnLastWindowClosed(False)
        self._window.close()
        QApplication.quit()
