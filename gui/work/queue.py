"""Jobs that are done one after the other, off the GUI's thread."""

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
    """What is to be done.

    Attributes
    ----------
    what : str
        As the user reads it while it is under way.
    do : callable
        Called off the GUI's thread.
    take : callable
        Takes what that has given, in the GUI's thread.
    fail : callable
        Takes the exception that has kept it from being done, in the GUI's thread.
    still_wanted : callable
        Asked when its turn has come: False to leave it out.
    passing : bool
        Whether it gives way to the next of its kind, if that comes before its turn.
    about : object
        What it is done to.
    """

    what: str
    do: Callable[[], Any]
    take: Callable[[Any], None]
    fail: Callable[[Exception], None]
    still_wanted: Callable[[], bool] = lambda: True
    passing: bool = False
    about: object = None


class JobLine(QObject):
    """Jobs in a line.

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
        """How many have ended since nothing was under way."""
        self._worker = Worker(self)
        self._worker.finished.connect(lambda answer: self._end(lambda job: job.take(answer)))
        self._worker.failed.connect(lambda error: self._end(lambda job: job.fail(error)))
        self._worker.cancelled.connect(lambda: self._end(lambda job: None))

    @property
    def busy(self) -> bool:
        """Whether anything is under way or waiting."""
        return self._job is not None or bool(self._waiting)

    @property
    def present(self) -> str:
        """What is being done; "" when nothing is."""
        return "" if self._job is None else self._job.what

    @property
    def to_come(self) -> int:
        """How many have not ended."""
        return len(self._waiting) + (self._job is not None)

    def has(self, about: object) -> bool:
        """Whether something is being done, or to be done, to this."""
        jobs = self._waiting if self._job is None else (self._job, *self._waiting)
        return any(job.about is about for job in jobs)

    def add(self, job: Job) -> None:
        """Do this after those that wait."""
        if job.passing:
            self._waiting = deque(other for other in self._waiting if not other.passing)
        self._waiting.append(job)
        self._next()

    def give_up(self, unwanted: Callable[[object], bool]) -> None:
        """Stop what is being done to something that nobody wants any more; nothing is heard of it."""
        if self._job is not None and self._job.about is not None and unwanted(self._job.about):
            self._worker.cancel()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._waiting.clear()
        return self._worker.shutdown()

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

    def _end(self, tell: Callable[[Job], None]) -> None:
        job, self._job = self._job, None
        self.done += 1
        try:
            if job is not None:
                tell(job)
        finally:
            self._next()


def _steps(job: Job) -> Generator[None, None, Any]:
    yield None  # so that it can be given up before it has begun
    return job.do()
