"""Headless use of the window: open, run, save a screenshot, exit."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from ilf._runtime.writing import ensure_folder
from ilf.data.results import Status
from ilf.errors import IlfError, InputError

from ..features.expected_error import ErrorFeature
from ..widgets.file_choice import write_picture
from .main_window import MainWindow

_POLL_MS = 20
_SETTLE_S = 0.4


class HeadlessRun(QObject):
    """Waits for the frames, runs the last one on request, and on request saves a screenshot and quits; without one, the
    window is left to the user.

    Any error is printed as one line on stderr and sets `status`, the exit status, to 1. Then nothing more is run and
    no screenshot is saved.
    """

    def __init__(self, window: MainWindow, run: bool, picture: Path | None) -> None:
        super().__init__(window)
        self._window = window
        self._picture = picture
        self.status = 0
        # no user can confirm the loss of work
        window.project.discard_silently = picture is not None
        window.notes.reported.connect(self.note_failure)
        self._steps = self._work(run)
        self._timer = QTimer(self, interval=_POLL_MS)
        self._timer.timeout.connect(self._go_on)
        self._timer.start()

    def note_failure(self, what: str) -> None:
        """Print an error in one line."""
        self.status = 1
        print("ilf-gui: error:", " ".join(what.split()), file=sys.stderr, flush=True)

    def _go_on(self) -> None:
        """Take the next step unless something has failed; after the last one, quit."""
        try:
            if not self.status and next(self._steps, self) is not self:
                return
        except IlfError as error:
            self.note_failure(str(error))
        self._timer.stop()
        if self._picture is not None:
            # closing the last window would quit a second time and end the next event loop
            QApplication.setQuitOnLastWindowClosed(False)
            self._window.close()
            QApplication.quit()

    def _work(self, run: bool) -> Iterator[None]:
        """Do all that was asked for; yield while something is awaited."""
        window, workspace = self._window, self._window.workspace
        while window.loader.busy:
            yield
        if workspace.shown is None and self._picture is not None:
            self._check_without_frame(run)
        if run and workspace.shown is not None:
            if not workspace.current.counts():
                raise InputError(
                    f"{workspace.current.name} has no blocks to complete: "
                    "draw blocks in the window, or extract them with other parameters."
                )
            window.runs.current.start()
            while not window.runs.state.free:
                yield
            yield  # an error of the run comes first
            self._check_results()
        if self._picture is not None:
            settled = time.monotonic() + _SETTLE_S
            # the expected error, if it is shown, is computed after the run
            while time.monotonic() < settled or window.feature(ErrorFeature).busy:
                yield
            ensure_folder(self._picture.parent)
            write_picture(self._picture, window.documents.picture())

    def _check_without_frame(self, run: bool) -> None:
        """Raise InputError if a frame could not be opened, or is needed."""
        for entry in self._window.workspace.entries:
            if entry.summary.problem:
                raise InputError(f"{entry.name}: {entry.summary.problem}")
        if run:
            raise InputError("There is no frame to run: give a frame folder, or a colour file and its depth file.")

    def _check_results(self) -> None:
        """Raise InputError if no block could be completed."""
        document = self._window.workspace.current
        outcomes = [result.outcome for result in document.valid_results().values()]
        if outcomes and all(outcome.status is Status.NOT_RECOVERABLE for outcome in outcomes):
            reason = outcomes[0].message
            raise InputError(f"{document.name}: no block could be completed. First block: {reason}")
