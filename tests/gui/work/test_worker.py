"""The worker: a job off the GUI's thread, its pace and its end."""

import gc
import threading
import weakref

import pytest

from gui.work.jobs import Order, Worker
from ilf._runtime.long_work import check_cancelled


@pytest.fixture
def until(qtbot):
    """Waits until something holds."""
    return qtbot.waitUntil


class Job:
    """A generator of numbers that waits for the test before each."""

    def __init__(self, steps=3, error=None):
        self.gate = threading.Semaphore(0)
        self.closed = False
        self._steps, self._error = steps, error

    def __call__(self):
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
def worker(qapp):
    worker = Worker()
    yield worker
    worker.shutdown()


@pytest.fixture
def said(worker):
    """What the worker sends: every item that was yielded, and how it ended."""
    heard = []
    worker.progressed.connect(heard.extend)
    worker.finished.connect(lambda value: heard.append(("finished", value)))
    worker.failed.connect(lambda error: heard.append(("failed", error)))
    worker.cancelled.connect(lambda: heard.append("cancelled"))
    worker.paused.connect(lambda: heard.append("paused"))
    return heard


def test_a_job_from_start_to_end(worker, said, until):
    assert not worker.busy
    assert not worker.is_paused
    job = Job()
    worker.start(job)
    assert worker.busy
    with pytest.raises(RuntimeError, match="already in progress"):
        worker.start(Job())
    job.gate.release(3)
    until(lambda: not worker.busy)
    assert said == [0, 1, 2, ("finished", "done")]
    again = Job(1)
    again.gate.release()
    worker.start(again)
    until(lambda: not worker.busy)
    assert said[4:] == [0, ("finished", "done")]


def test_what_was_yielded_before_a_cancel_still_comes(worker, said, until):
    job = Job()
    worker.start(job)
    job.gate.release()
    until(lambda: said == [0])
    worker.cancel()
    worker.order(Order.RUN)
    assert not worker.is_paused
    job.gate.release()
    until(lambda: not worker.busy)
    assert said == [0, 1, "cancelled"]
    assert job.closed


def test_nothing_is_heard_after_a_shutdown(worker, said, qtbot):
    assert worker.shutdown(), "nothing runs"
    job = Job()
    worker.start(job)
    job.gate.release(3)
    assert worker.shutdown()
    assert not worker.busy
    qtbot.wait(60)
    assert said == []


def test_a_thread_that_does_not_end_is_not_waited_for_for_ever(worker, said, until, monkeypatch):
    monkeypatch.setattr("gui.work.jobs.SHUTDOWN_LIMIT_S", 0.05)
    job = Job()
    worker.start(job)
    assert not worker.shutdown()
    assert not worker.busy
    job.gate.release(3)
    until(lambda: job.closed)
    worker.cancel()
    assert said == [], "what it does later is not heard"


def test_what_a_job_has_given_is_not_kept(worker, until):
    class Large:
        """Something that takes room."""

    kept = []

    def job():
        yield None
        return Large()

    worker.finished.connect(lambda large: kept.append(weakref.ref(large)))
    worker.start(job)
    until(lambda: not worker.busy and bool(kept))
    gc.collect()
    assert kept[0]() is None


def test_a_job_that_ends_the_interpreter_s_way_fails(worker, said, until):
    def job():
        yield 1
        raise SystemExit(3)

    worker.start(job)
    until(lambda: not worker.busy)
    (_, (how, error)) = said
    assert how == "failed"
    assert "SystemExit(3)" in str(error)


def test_a_job_that_does_not_hear_is_left_alone(worker, said, until):
    deaf = Job(2)
    worker.start(deaf)
    deaf.gate.release()
    until(lambda: said == [0])
    worker.cancel()
    until(lambda: not worker.busy)
    assert said == [0, "cancelled"]
    again = Job(1)
    again.gate.release()
    worker.start(again)
    until(lambda: not worker.busy)
    deaf.gate.release(2)
    assert said == [0, "cancelled", 0, ("finished", "done")]


def test_work_within_a_step_stops(worker, said, until):
    begun = threading.Event()

    def job():
        begun.set()
        while True:
            check_cancelled()
        yield 1

    worker.start(job)
    assert begun.wait(20)
    assert worker.shutdown()
    worker.start(job)
    worker.cancel()
    until(lambda: not worker.busy)
    assert said == ["cancelled"]


def test_what_is_to_be_finished_is(qapp, monkeypatch):
    monkeypatch.setattr("gui.work.jobs.SHUTDOWN_LIMIT_S", 0.05)
    worker, begun, gate, done = Worker(must_finish=True), threading.Event(), threading.Event(), []

    def job():
        yield None
        begun.set()
        assert gate.wait(20)
        check_cancelled()
        done.append(True)

    worker.start(job)
    assert begun.wait(20)
    later = threading.Timer(0.2, gate.set)
    later.start()
    assert worker.shutdown()
    assert done
    later.join()
