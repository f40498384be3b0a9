"""Background computation of the latest request, as while a slider is moved; and queues of jobs, which are all done."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from .jobs import Worker

Answer = TypeVar("Answer")


@dataclass(frozen=True, eq=False)
class Job:
    """What is computed, and who is told.

    Attributes
    ----------
    find : callable
        Returns the answer, or a generator that yields shares done (0-1) and parts, and returns it; called in the
        background thread.
    take, fail, step : callable
        Called with the answer, with the exception that `find` or `take` has raised, and with each part, in the GUI's
        thread.
    kind : str
        Of those of a kind, the latest waits; those of the kind "" are all done.
    key : object
        What is asked for: a job in progress with an equal key gives the same answer. None for a job that has no equal.
    what : str
        Description for the user while it is in progress.
    still_wanted : callable
        Called before the job starts; a queue skips it if it returns False.
    about : object
        The object that it works on.
    """

    find: Callable[[], Any]
    take: Callable[[Any], object]
    fail: Callable[[Exception], object]
    step: Callable[[Any], object] = lambda part: None
    kind: str = ""
    key: object = None
    what: str = ""
    still_wanted: Callable[[], bool] = lambda: True
    about: object = None

    def answer(self, found: Any) -> None:
        """Give the answer to who has asked."""
        try:
            self.take(found)
        except Exception as error:
            self.fail(error)


def _raise(error: Exception) -> None:
    raise error


class LatestRequest(QObject):
    """Answers one question at a time; a new question replaces the one of its kind that waits.

    A question in progress is still answered when a newer one arrives, so that the window is updated during a drag;
    after `forget`, older questions are not answered any more.

    Parameters
    ----------
    fail : callable
        Called with the exception of a question that has no `fail` of its own.
    must_finish : bool
        Whether the question in progress is always finished and waited for, as writing to disk must be.

    Signals
    -------
    progressed(float)
        The share done of the question in progress.
    begun(), ended()
        Work on a question has begun, has ended in any way.
    """

    progressed = Signal(float)
    begun = Signal()
    ended = Signal()

    def __init__(
        self,
        parent: QObject | None = None,
        fail: Callable[[Exception], object] = _raise,
        must_finish: bool = False,
    ) -> None:
        super().__init__(parent)
        self._fail = fail
        self._worker = Worker(self, must_finish)
        self._worker.finished.connect(lambda answer: self._end(lambda job: job.answer(answer)))
        self._worker.failed.connect(lambda error: self._end(lambda job: job.fail(error)))
        self._worker.cancelled.connect(self._go_on)
        self._worker.progressed.connect(self._advance)
        self._waiting: list[Job] = []
        self.question: Job | None = None
        """The question in progress; None once its answer is no longer needed."""

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self._worker.busy or bool(self._waiting)

    def ask(
        self,
        find: Callable[[], Answer | Generator[Any, None, Answer]],
        take: Callable[[Answer], object],
        fail: Callable[[Exception], object] | None = None,
        kind: str = "latest",
        **options: Any,
    ) -> None:
        """Call `take` with what `find` returns in the background, or `fail` with the exception of either; further
        options are those of `Job`."""
        self.add(Job(find, take, fail or self._fail, kind=kind, **options))

    def add(self, job: Job) -> None:
        """Do a job once there is time."""
        self._waiting = [one for one in self._waiting if not job.kind or one.kind != job.kind]
        current = self.question
        if job.key is None or current is None or (current.kind, current.key) != (job.kind, job.key):
            self._waiting.append(job)
        self._start()

    def forget(self) -> None:
        """Drop all questions asked so far."""
        self._waiting = []
        self.question = None

    def cancel(self) -> None:
        """Drop all questions asked so far, and end the work on the one in progress."""
        self.forget()
        self._worker.cancel()

    def _start(self) -> None:
        if self._worker.busy or not self._waiting:
            return
        self.question = self._waiting.pop(0)
        find = self.question.find

        def steps() -> Generator[Any, None, Any]:
            yield None
            answer = find()
            if isinstance(answer, Generator):
                answer = yield from answer
            return answer

        self.begun.emit()
        self._worker.start(steps)

    def _advance(self, items: list[Any]) -> None:
        shares = [item for item in items if isinstance(item, int | float)]
        for part in items:
            if self.question is not None and part is not None and not isinstance(part, int | float):
                self.question.step(part)
        if shares:
            self.progressed.emit(shares[-1])

    def _end(self, tell: Callable[[Job], object]) -> None:
        asked, self.question = self.question, None
        try:
            if asked is not None:
                tell(asked)
        finally:
            self._go_on()

    def _go_on(self) -> None:
        self.ended.emit()
        self._start()


class JobQueue(LatestRequest):
    """Jobs that are all done, in their order, but for those of a kind.

    Signals
    -------
    changed()
        `busy` or `pending` has changed.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.done = 0
        """Number of jobs that have ended since the queue was last idle."""

    @property
    def pending(self) -> list[Job]:
        """Jobs that have not ended, the one in progress first."""
        return [*([] if self.question is None else [self.question]), *self._waiting]

    def cancel_if(self, unwanted: Callable[[object], bool]) -> None:
        """Cancel the current job if its object is no longer wanted; it does not report."""
        if self.question and self.question.about is not None and unwanted(self.question.about):
            self.question = None
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
