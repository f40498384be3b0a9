"""What works off the GUI's thread, and what draws: the worker, the latest question, and the refresh."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterator
from typing import Any

import pytest
from PySide6.QtCore import QObject, Signal
from pytestqt.qtbot import QtBot

from gui.work import refresh as refresh_module
from gui.work.latest_question import LatestQuestion
from gui.work.refresh import Refresh
from gui.work.worker import Worker

WAIT_MS = 10_000
Until = Callable[[Callable[[], bool]], None]


@pytest.fixture
def until(qtbot: QtBot) -> Until:
    """Waits until something holds."""
    return lambda holds: qtbot.waitUntil(holds, timeout=WAIT_MS)


# the worker


class Job:
    """A generator of numbers that waits for the test before each."""

    def __init__(self, steps: int = 3, error: Exception | None = None) -> None:
        self.gate = threading.Semaphore(0)
        self.closed = False
        self._steps, self._error = steps, error

    def __call__(self) -> Generator[int, None, str]:
        try:
            for number in range(self._steps):
                assert self.gate.acquire(timeout=20)
                yield number
            if self._error is not None:
                raise self._error
            return "done"
        finally:
            self.closed = True


@pytest.fixture
def worker(qapp: object) -> Iterator[Worker]:
    worker = Worker()
    yield worker
    worker.shutdown()


@pytest.fixture
def said(worker: Worker) -> list[Any]:
    """What the worker sends: every item that was yielded, and how it ended."""
    heard: list[Any] = []
    worker.progressed.connect(heard.extend)
    worker.finished.connect(lambda value: heard.append(("finished", value)))
    worker.failed.connect(lambda error: heard.append(("failed", error)))
    worker.cancelled.connect(lambda: heard.append("cancelled"))
    worker.paused.connect(lambda: heard.append("paused"))
    return heard


def test_a_job_from_start_to_end(worker: Worker, said: list[Any], until: Until) -> None:
    assert not worker.busy
    assert not worker.is_paused
    job = Job()
    worker.start(job)
    assert worker.busy
    with pytest.raises(RuntimeError, match="under way"):
        worker.start(Job())
    job.gate.release(3)
    until(lambda: not worker.busy)
    assert said == [0, 1, 2, ("finished", "done")]
    again = Job(1)
    again.gate.release()
    worker.start(again)
    until(lambda: not worker.busy)
    assert said[4:] == [0, ("finished", "done")]


def test_an_exception_is_brought_to_the_gui(worker: Worker, said: list[Any], until: Until) -> None:
    error = ValueError("broken")
    job = Job(1, error)
    job.gate.release()
    worker.start(job)
    until(lambda: not worker.busy)
    assert said == [0, ("failed", error)]


def test_what_was_yielded_before_a_cancel_still_comes(worker: Worker, said: list[Any], until: Until) -> None:
    job = Job()
    worker.start(job)
    job.gate.release()
    until(lambda: said == [0])
    worker.cancel()
    worker.resume()
    assert not worker.is_paused
    job.gate.release()
    until(lambda: not worker.busy)
    assert said == [0, 1, "cancelled"]
    assert job.closed


def test_a_job_that_ends_as_it_is_cancelled_is_cancelled(worker: Worker, said: list[Any], until: Until) -> None:
    job = Job(1)
    worker.start(job)
    worker.cancel()
    job.gate.release()
    until(lambda: not worker.busy)
    assert said[-1] == "cancelled"


def test_pausing_stepping_and_going_on(worker: Worker, said: list[Any], until: Until) -> None:
    job = Job(5)
    job.gate.release(5)
    worker.start(job, paused=True)
    until(lambda: said == [0, "paused"])
    assert worker.busy
    assert worker.is_paused
    worker.step()
    until(lambda: said == [0, "paused", 1, "paused"])
    worker.step()
    until(lambda: said[-2:] == [2, "paused"])
    worker.resume()
    until(lambda: not worker.busy)
    assert [item for item in said if item != "paused"] == [0, 1, 2, 3, 4, ("finished", "done")]
    assert said.count("paused") == 3
    assert not worker.is_paused


def test_a_paused_job_can_be_cancelled(worker: Worker, said: list[Any], until: Until) -> None:
    job = Job()
    job.gate.release(3)
    worker.start(job, paused=True)
    until(lambda: said == [0, "paused"])
    worker.cancel()
    until(lambda: not worker.busy)
    assert said == [0, "paused", "cancelled"]


def test_a_pause_takes_hold_after_the_present_step(worker: Worker, said: list[Any], until: Until) -> None:
    job = Job()
    worker.start(job)
    worker.pause()
    job.gate.release(3)
    until(lambda: "paused" in said)
    assert said == [0, "paused"]
    worker.resume()
    until(lambda: not worker.busy)
    assert said == [0, "paused", 1, 2, ("finished", "done")]


def test_nothing_is_heard_after_a_shutdown(worker: Worker, said: list[Any], qtbot: QtBot) -> None:
    assert worker.shutdown(), "nothing runs"
    job = Job()
    worker.start(job)
    job.gate.release(3)
    assert worker.shutdown()
    assert not worker.busy
    qtbot.wait(60)
    assert said == []


def test_a_thread_that_does_not_end_is_not_waited_for_for_ever(worker: Worker, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gui.work.worker.SHUTDOWN_LIMIT_S", 0.05)
    job = Job()
    worker.start(job)
    assert not worker.shutdown()
    assert worker.busy
    job.gate.release(3)
    monkeypatch.setattr("gui.work.worker.SHUTDOWN_LIMIT_S", 20)
    assert worker.shutdown()


# the latest question


class Oracle:
    """Answers a question with its double when it may; "no" breaks it."""

    def __init__(self) -> None:
        self.gate = threading.Semaphore(0)
        self.asked: list[object] = []

    def __call__(self, question: object) -> object:
        self.asked.append(question)
        assert self.gate.acquire(timeout=20)
        if question == "no":
            raise ValueError("no answer")
        return f"{question}{question}"


@pytest.fixture
def oracle() -> Oracle:
    return Oracle()


@pytest.fixture
def latest(oracle: Oracle, qapp: object) -> Iterator[LatestQuestion[str, object]]:
    latest: LatestQuestion[str, object] = LatestQuestion(oracle)
    yield latest
    oracle.gate.release(100)
    latest.shutdown()


@pytest.fixture
def heard(latest: LatestQuestion[str, object]) -> list[tuple[object, object]]:
    """Questions with their answers, or the class of what went wrong."""
    pairs: list[tuple[object, object]] = []
    latest.answered.connect(lambda question, answer: pairs.append((question, answer)))
    latest.failed.connect(lambda question, error: pairs.append((question, type(error))))
    return pairs


Latest = LatestQuestion[str, object]
Heard = list[tuple[object, object]]


def test_of_the_questions_that_come_meanwhile_the_latest_is_answered(
    latest: Latest, oracle: Oracle, heard: Heard, until: Until
) -> None:
    assert not latest.busy
    for question in "abc":
        latest.ask(question)
    assert latest.busy
    oracle.gate.release(2)
    until(lambda: not latest.busy)
    assert heard == [("a", "aa"), ("c", "cc")]
    assert oracle.asked == ["a", "c"]


def test_the_same_question_is_answered_once(latest: Latest, oracle: Oracle, heard: Heard, until: Until) -> None:
    latest.ask("a")
    latest.ask("b")
    latest.ask("a")
    oracle.gate.release(2)
    until(lambda: not latest.busy)
    assert heard == [("a", "aa")]
    latest.ask("a")
    until(lambda: len(heard) == 2)
    assert oracle.asked == ["a", "a"], "later it is another question"


def test_a_question_that_cannot_be_answered_lets_the_next_one_through(
    latest: Latest, oracle: Oracle, heard: Heard, until: Until
) -> None:
    latest.ask("no")
    latest.ask("b")
    oracle.gate.release(2)
    until(lambda: not latest.busy)
    assert heard == [("no", ValueError), ("b", "bb")]


def test_nothing_is_heard_of_what_was_forgotten(latest: Latest, oracle: Oracle, heard: Heard, until: Until) -> None:
    latest.ask("a")
    latest.ask("b")
    latest.forget()
    latest.ask("c")
    oracle.gate.release(2)
    until(lambda: len(heard) == 1 and not latest.busy)
    assert heard == [("c", "cc")]
    assert oracle.asked == ["a", "c"]
    latest.ask("no")
    latest.forget()
    oracle.gate.release()
    until(lambda: not latest.busy)
    assert len(heard) == 1


def test_a_shutdown_answers_nothing_any_more(latest: Latest, oracle: Oracle, heard: Heard, qtbot: QtBot) -> None:
    latest.ask("a")
    latest.ask("b")
    oracle.gate.release(2)
    assert latest.shutdown()
    qtbot.wait(60)
    assert heard == []
    assert not latest.busy


# the refresh


class Source(QObject):
    """Signals that make parts stale."""

    quick = Signal()
    other = Signal(object)
    often = Signal()


class Parts:
    """Two parts of a window, and how often they were drawn."""

    def __init__(self) -> None:
        self.source = Source()
        self.refresh = Refresh()
        self.drawn: list[str] = []
        self.refresh.add("first", lambda: self.drawn.append("first"), (self.source.quick,))
        self.refresh.add(
            "second", lambda: self.drawn.append("second"), (self.source.quick, self.source.other), (self.source.often,)
        )

    def take(self) -> list[str]:
        """What has been drawn since the last time."""
        drawn, self.drawn[:] = list(self.drawn), []
        return drawn


@pytest.fixture
def parts(qapp: object, monkeypatch: pytest.MonkeyPatch) -> Iterator[Parts]:
    monkeypatch.setattr(refresh_module, "_INTERVAL_S", 0.0)
    parts = Parts()
    yield parts
    parts.refresh.stop()


def test_a_part_is_drawn_once_a_turn_in_the_order_of_the_parts(parts: Parts, until: Until) -> None:
    parts.source.other.emit(1)
    parts.source.quick.emit()
    parts.source.quick.emit()
    assert parts.take() == [], "not before the event loop's next turn"
    until(lambda: bool(parts.drawn))
    assert parts.take() == ["first", "second"]
    parts.source.other.emit(2)
    until(lambda: bool(parts.drawn))
    assert parts.take() == ["second"]


def test_what_can_wait_comes_in_its_time(parts: Parts, until: Until) -> None:
    parts.source.often.emit()
    until(lambda: bool(parts.drawn))
    assert parts.take() == ["second"]
    parts.source.often.emit()
    parts.source.often.emit()
    until(lambda: bool(parts.drawn))
    assert parts.take() == ["second"]


def test_what_can_wait_is_not_drawn_again_too_soon(
    parts: Parts, until: Until, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(refresh_module, "_INTERVAL_S", 1e6)
    parts.source.often.emit()
    until(lambda: bool(parts.drawn))
    parts.take()
    parts.source.often.emit()
    qtbot.wait(60)
    assert parts.take() == []
    parts.source.quick.emit()
    until(lambda: bool(parts.drawn))
    assert parts.take() == ["first", "second"], "it comes with what cannot wait"
    qtbot.wait(60)
    assert parts.take() == []


def test_drawing_at_once(parts: Parts, qtbot: QtBot) -> None:
    parts.refresh.now()
    assert parts.take() == []
    parts.refresh.mark("first")
    parts.refresh.now()
    assert parts.take() == ["first"]
    qtbot.wait(30)
    assert parts.take() == [], "it is stale no more"
    parts.refresh.draw_all()
    assert parts.take() == ["first", "second"]


def test_a_part_that_is_made_stale_by_another_is_drawn_in_the_next_turn(parts: Parts, until: Until) -> None:
    parts.refresh.add("third", lambda: parts.refresh.mark("first"), (parts.source.other,))
    parts.source.other.emit(0)
    until(lambda: parts.drawn == ["second", "first"])


def test_nothing_is_drawn_after_the_end(parts: Parts, qtbot: QtBot) -> None:
    parts.source.quick.emit()
    parts.source.often.emit()
    parts.refresh.stop()
    parts.source.quick.emit()
    qtbot.wait(60)
    assert parts.take() == []
