"""Driving several generators at once, in slices, at the pace of whoever takes what they yield."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import Generic, TypeVar

from .stopping import heed, present_wishes

T = TypeVar("T")
Steps = Generator[T, None, None]

SLICE_S = 0.005
"""Seconds of work that are handed to a thread at a time: steps of microseconds drown in the handing over."""

_SWITCH_S = 0.0002
"""How long a thread waits for the interpreter's lock before it is handed over. Python's own 5 ms are longer than most
of what threads do without it: one would be at rest while the other takes it up again and again."""


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def one_by_one(tasks: Iterable[Steps[T]]) -> Steps[T]:
    """All that the tasks yield, one task after the other, in the caller's thread."""
    for task in tasks:
        yield from task


def side_by_side(tasks: Sequence[Steps[T]], width: int) -> Steps[T]:
    """All that the tasks yield, `width` of them at a time, each in its own order.

    A thread takes a task and goes on with it, slice by slice, until its end; no more than a slice ahead of who takes
    what the tasks yield. An exception in a task comes out here. When this generator ends or is closed, so have its
    threads: what they are at is stopped (see `ilf.stopping`).

    Parameters
    ----------
    tasks : sequence of generator
        In the order in which they are begun.
    width : int
        Number of threads.
    """
    team = _Team(tasks, width)
    wishes = *present_wishes(), team.stopped
    pool = ThreadPoolExecutor(width, thread_name_prefix="ilf-block", initializer=heed, initargs=wishes)
    _switching.begin()
    try:
        for _ in range(width):
            pool.submit(team.work)
        yield from team.results()
    finally:
        team.stop()
        pool.shutdown()
        _switching.end()


class _Switching:
    """The interpreter hands its lock over sooner while any threads share tasks."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._teams = 0
        self._usual = 0.0

    def begin(self) -> None:
        with self._lock:
            if self._teams == 0:
                self._usual = sys.getswitchinterval()
                sys.setswitchinterval(min(_SWITCH_S, self._usual))
            self._teams += 1

    def end(self) -> None:
        with self._lock:
            self._teams -= 1
            if self._teams == 0:
                sys.setswitchinterval(self._usual)


_switching = _Switching()


class _Team(Generic[T]):
    """Threads that share tasks, and what they hand over."""

    def __init__(self, tasks: Sequence[Steps[T]], width: int) -> None:
        self._width = width
        self._tasks = iter(tasks)
        self._taking = threading.Lock()
        self.stopped = threading.Event()
        self._ahead = threading.Semaphore(2 * width)
        # slices of items; what a thread ends with, None or what went wrong
        self._done = SimpleQueue[list[T] | BaseException | None]()

    def work(self) -> None:
        """What every thread does."""
        end: BaseException | None = None
        try:
            while (task := self._next_task()) is not None:
                self._finish(task)
        except BaseException as error:  # for the thread that waits for it
            end = error
        self._done.put(end)

    def results(self) -> Steps[T]:
        """All that the tasks yield, as it comes."""
        working = self._width
        while working:
            done = self._done.get()
            if isinstance(done, BaseException):
                raise done
            if done is None:
                working -= 1
            else:
                self._ahead.release()
                yield from done

    def stop(self) -> None:
        """Let the threads end, at the next item of their tasks."""
        self.stopped.set()
        self._ahead.release(self._width)

    def _next_task(self) -> Steps[T] | None:
        with self._taking:
            return None if self.stopped.is_set() else next(self._tasks, None)

    def _finish(self, task: Steps[T]) -> None:
        ended = False
        while not ended:
            self._ahead.acquire()
            if self.stopped.is_set():
                return
            items, ended = self._slice(task)
            self._done.put(items)

    def _slice(self, task: Steps[T]) -> tuple[list[T], bool]:
        """What a task yields in a slice, and whether that was its end."""
        items: list[T] = []
        end = time.perf_counter() + SLICE_S
        for item in task:
            items.append(item)
            if self.stopped.is_set() or time.perf_counter() >= end:
                return items, False
        return items, True
