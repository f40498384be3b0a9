"""Background computation of the latest request, as while a slider is moved."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from .jobs import Worker

Request = TypeVar("Request")
Answer = TypeVar("Answer")


class LatestRequest(QObject, Generic[Request, Answer]):
    """Computes answers to one question at a time; a new question replaces the one that waits.

    A question in progress is still answered when a newer one arrives, so that the window is updated during a drag;
    after `forget`, older questions are not answered any more.

    Parameters
    ----------
    answer : callable
        Given a question, returns its answer; called in the background thread.

    Signals
    -------
    answered(object, object)
        A question and its answer.
    failed(object, object)
        A question and the exception that was raised.
    """

    answered = Signal(object, object)
    failed = Signal(object, object)

    def __init__(self, answer: Callable[[Request], Answer], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._answer = answer
        self._worker = Worker(self)
        self._worker.finished.connect(self._take)
        self._worker.failed.connect(self._fail)
        self._waiting: list[Request] = []
        self._current: list[Request] = []
        """The question in progress; empty once its answer is no longer needed."""

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self._worker.busy or bool(self._waiting)

    def ask(self, question: Request) -> None:
        """Compute an answer; `answered` or `failed` follows, once for equal questions asked meanwhile."""
        self._waiting = [] if question in self._current else [question]
        self._start()

    def forget(self) -> None:
        """Drop all questions asked so far."""
        self._waiting = []
        self._current = []

    def shutdown(self) -> bool:
        """Stop permanently, before the window closes. True if the thread has ended."""
        self.forget()
        return self._worker.shutdown()

    def _start(self) -> None:
        if self._worker.busy or not self._waiting:
            return
        self._current, self._waiting = self._waiting, []
        question = self._current[0]

        def job() -> Generator[None, None, Answer]:
            yield None
            return self._answer(question)

        self._worker.start(job)

    def _take(self, answer: Answer) -> None:
        asked, self._current = self._current, []
        for question in asked:
            self.answered.emit(question, answer)
        self._start()

    def _fail(self, error: Exception) -> None:
        asked, self._current = self._current, []
        for question in asked:
            self.failed.emit(question, error)
        self._start()
