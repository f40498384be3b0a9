"""Background computation of the latest request, as while a slider is moved."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal, SignalInstance

from .jobs import Worker

Request = TypeVar("Request")
Answer = TypeVar("Answer")


class LatestRequest(QObject, Generic[Request, Answer]):
    """Computes answers to one question at a time; a new question replaces the one of its class that waits.

    A question in progress is still answered when a newer one arrives, so that the window is updated during a drag;
    after `forget`, older questions are not answered any more.

    Parameters
    ----------
    answer : callable
        Given a question, returns its answer, or is a generator that yields shares done (0-1) and returns it; called
        in the background thread.

    Signals
    -------
    answered(object, object)
        A question and its answer.
    failed(object, object)
        A question and the exception that was raised.
    progressed(float)
        The share done of the question in progress.
    begun(), ended()
        Work on a question has begun, has ended in any way.
    """

    answered = Signal(object, object)
    failed = Signal(object, object)
    progressed = Signal(float)
    begun = Signal()
    ended = Signal()

    def __init__(
        self,
        answer: Callable[[Request], Answer | Generator[float | None, None, Answer]],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._answer = answer
        self._worker = Worker(self)
        self._worker.finished.connect(lambda answer: self._end(self.answered, answer))
        self._worker.failed.connect(lambda error: self._end(self.failed, error))
        self._worker.cancelled.connect(self._go_on)
        self._worker.progressed.connect(self._show_share)
        self._waiting: list[Request] = []
        self._current: list[Request] = []
        """The question in progress; empty once its answer is no longer needed."""

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self._worker.busy or bool(self._waiting)

    @property
    def question(self) -> Request | None:
        """The question in progress whose answer is needed; None for none."""
        return self._current[0] if self._current else None

    def ask(self, question: Request) -> None:
        """Compute an answer; `answered` or `failed` follows, once for equal questions asked meanwhile."""
        self._waiting = [one for one in self._waiting if type(one) is not type(question)]
        if question not in self._current:
            self._waiting.append(question)
        self._start()

    def forget(self) -> None:
        """Drop all questions asked so far."""
        self._waiting = []
        self._current = []

    def cancel(self) -> None:
        """Drop all questions asked so far, and end the work on the one in progress."""
        self.forget()
        self._worker.cancel()

    def _start(self) -> None:
        if self._worker.busy or not self._waiting:
            return
        self._current, self._waiting = self._waiting[:1], self._waiting[1:]
        question = self._current[0]

        def job() -> Generator[float | None, None, Answer]:
            yield None
            answer = self._answer(question)
            if isinstance(answer, Generator):
                answer = yield from answer
            return answer

        self.begun.emit()
        self._worker.start(job)

    def _show_share(self, shares: list[float | None]) -> None:
        if shares[-1] is not None:
            self.progressed.emit(shares[-1])

    def _end(self, signal: SignalInstance, found: Answer | Exception) -> None:
        asked, self._current = self._current, []
        for question in asked:
            signal.emit(question, found)
        self._go_on()

    def _go_on(self) -> None:
        self.ended.emit()
        self._start()
