"""A queue of jobs, executed one after the other in a background thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from .jobs import Worker


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
    take: Callable[[Any], None]
    fail: Callable[[Exception], None]
    still_wanted: Callable[[], bool] = lambda: True
    transient: bool = False
    about: object = None


class JobQueue(QObject):
    """A queue of jobs.

    Signals
    -------
    changed()
        `busy` or `present` has changed.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: deque[Job] = deque()
        self._job: Job | None = None
        self.done = 0
        """Number of jobs that have ended since the queue was last idle."""
        self._worker = Worker(self)
        self._worker.finished.connect(lambda answer: self._end(lambda job: job.take(answer)))
        self._worker.failed.connect(lambda error: self._end(lambda job: job.fail(error)))
        self._worker.cancelled.connect(lambda: self._end(lambda job: None))

    @property
    def busy(self) -> bool:
        """Whether a job is in progress or waiting."""
        return self._job is not None or bool(self._waiting)

    @property
    def present(self) -> str:
        """Description of the job in progress; "" for none."""
        return "" if self._job is None else self._job.what

    @property
    def pending_count(self) -> int:
        """Number of jobs that have not ended."""
        return len(self._waiting) + (self._job is not None)

    def has(self, about: object) -> bool:
        """Whether a job on this object is in progress or waiting."""
        jobs = self._waiting if self._job is None else (self._job, *self._waiting)
        return any(job.about is about for job in jobs)

    def add(self, job: Job) -> None:
        """Append a job."""
        if job.transient:
            self._waiting = deque(other for other in self._waiting if not other.transient)
        self._waiting.append(job)
        self._next()

    def cancel_if(self, unwanted: Callable[[object], bool]) -> None:
        """Cancel the current job if its object is no longer wanted; it does not report."""
        if self._job is not None and self._job.about is not None and unwanted(self._job.about):
            self._worker.cancel()

    def _next(self) -> None:
        if self._job is not None:
            return
        while self._waiting and self._job is None:
            job = self._waiting.popleft()
            if job.still_wanted():
                self._job = job
                self._worker.start(partial(_steps, job))
        if self._job is None:
            self.done = 0
        self.changed.emit()

    def _end(self, handle: Callable[[Job], None]) -> None:
        job, self._job = self._job, None
        self.done += 1
        try:
            if job is not None:
                handle(job)
        finally:
            self._next()


def _steps(job: Job) -> Generator[None, None, Any]:
    yield None  # so that it can be cancelled before it starts
    return job.do()
