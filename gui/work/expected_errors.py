"""The expected error of what has been completed, worked out off the GUI's thread."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from gui.work.worker import Worker
from ilf.completion import Completion
from ilf.confidence import expected_error
from ilf.frame import RGBDFrame

_Answer = tuple[Completion, NDArray[np.float32]]


class ExpectedErrors(QObject):
    """Answers the latest question; questions that come while it is busy replace the one that waits.

    Signals
    -------
    found(object, object)
        The Completion that was asked about, and its expected error [m], float32 (H, W), NaN where not filled.
    failed(object)
        The exception that kept it from being found.
    """

    found = Signal(object, object)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker = Worker(self)
        self._worker.finished.connect(self._answer)
        self._worker.failed.connect(self._fail)
        self._next: tuple[RGBDFrame, Completion] | None = None
        self._present: Completion | None = None
        self._hopeless: Completion | None = None

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._worker.busy

    def ask(self, frame: RGBDFrame, completion: Completion) -> None:
        """Find the expected error of a frame's completion; `found` follows, once for all who ask for the same.

        Where it could not be found it is not tried again.
        """
        if completion is self._hopeless:
            return
        self._next = None if completion is self._present else (frame, completion)
        if not self._worker.busy:
            self._start()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._next = None
        return self._worker.shutdown()

    def _start(self) -> None:
        self._present = None
        if self._next is None:
            return
        (frame, completion), self._next = self._next, None
        self._present = completion

        def job() -> Generator[None, None, _Answer]:
            yield None
            return completion, expected_error(frame, completion)

        self._worker.start(job)

    def _answer(self, answer: _Answer) -> None:
        self.found.emit(*answer)
        self._start()

    def _fail(self, error: Exception) -> None:
        self._hopeless = self._present
        self.failed.emit(error)
        self._start()
