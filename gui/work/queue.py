"""A queue of jobs, executed one after the other in a background thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Signal

from .latest_request import LatestRequest


@dataclass(frozen=True, eq=False)
class Job:
    """A job of the queue.

    Attributes
    ----------
    what : str
        Description for the user while it is in progress.
    do : callable
        Called in the background thread.
    take : callable
        Called with its result in the GUI's thread.
    fail : callable
        Called with an exception in the GUI's thread.
    still_wanted : callable
        Called before the job starts; the job is skipped if it returns False.
    transient : bool
        Whether a later job of this kind replaces it while it waits.
    about : object
        The object that it works on.
    """

    what: str
    do: Callable[[], Any]
    take: Callable[[Any], object]
    fail: Callable[[Exception], None]
    still_wanted: Callable[[], bool] = lambda: True
    transient: bool = False
    about: object = None


class JobQueue(LatestRequest[Job, Any]):
    """Requests that are jobs: all of them are done, in their order, but for transient ones.

    Signals
    -------
    changed()
        `busy` or `present` has changed.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(lambda job: job.do(), parent)
        self.done = 0
        """Number of jobs that have ended since the queue was last idle."""
        self.answered.connect(lambda job, answer: job.take(answer))
        self.failed.connect(lambda job, error: job.fail(error))

    @property
    def present(self) -> str:
        """Description of the job in progress; "" for none."""
        return self.question.what if self.question else ""

    @property
    def pending_count(self) -> int:
        """Number of jobs that have not ended."""
        return len(self._waiting) + len(self._current)

    def has(self, about: object) -> bool:
        """Whether a job on this object is in progress or waiting."""
        return any(job.about is about for job in (*self._current, *self._waiting))

    def ask(self, question: Job) -> None:
        """Append a job."""
        if question.transient:
            self._waiting = [other for other in self._waiting if not other.transient]
        self._waiting.append(question)
        self._start()

    def cancel_if(self, unwanted: Callable[[object], bool]) -> None:
        """Cancel the current job if its object is no longer wanted; it does not report."""
        if self.question and self.question.about is not None and unwanted(self.question.about):
            self._current = []
            self._worker.cancel()

    def _go_on(self) -> None:
        self.done += 1
        super()._go_on()

    def _start(self) -> None:
        if not self._worker.busy:
            while self._waiting and not self._waiting[0].still_wanted():
                del self._waiting[0]
            if not self._waiting:
                self.done = 0
        super()._start()
        self.changed.emit()
