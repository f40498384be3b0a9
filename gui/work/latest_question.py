"""Answering the latest question off the GUI's thread: what somebody who moves a slider wants to know."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from .jobs import Worker

Question = TypeVar("Question")
Answer = TypeVar("Answer")


class LatestQuestion(QObject, Generic[Question, Answer]):
    """Answers one question at a time; those that come meanwhile replace the one that waits.

    A question that has been overtaken while it was being answered is answered all the same, so that something moves
    during a drag; after `forget`, nothing is heard of older ones any more.

    Parameters
    ----------
    answer : callable
        Takes a question and gives its answer; called off the GUI's thread.

    Signals
    -------
    answered(object, object)
        A question and its answer.
    failed(object, object)
        A question and the exception that kept it from being answered.
    """

    answered = Signal(object, object)
    failed = Signal(object, object)

    def __init__(self, answer: Callable[[Question], Answer], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._answer = answer
        self._worker = Worker(self)
        self._worker.finished.connect(self._take)
        self._worker.failed.connect(self._fail)
        self._waiting: list[Question] = []
        self._present: list[Question] = []
        """The question under way; empty once nobody wants its answer."""

    @property
    def busy(self) -> bool:
        """Whether an answer is to come."""
        return self._worker.busy or bool(self._waiting)

    def ask(self, question: Question) -> None:
        """Find the answer; `answered` or `failed` follows, once for all who ask the same while it is looked for."""
        self._waiting = [] if question in self._present else [question]
        self._start()

    def forget(self) -> None:
        """Answer none of the questions asked so far."""
        self._waiting = []
        self._present = []

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self.forget()
        return self._worker.shutdown()

    def _start(self) -> None:
        if self._worker.busy or not self._waiting:
            return
        self._present, self._waiting = self._waiting, []
        question = self._present[0]

        def job() -> Generator[None, None, Answer]:
            yield None
            return self._answer(question)

        self._worker.start(job)

    def _take(self, answer: Answer) -> None:
        asked, self._present = self._present, []
        for question in asked:
            self.answered.emit(question, answer)
        self._start()

    def _fail(self, error: Exception) -> None:
        asked, self._present = self._present, []
        for question in asked:
            self.failed.emit(question, error)
        self._start()
