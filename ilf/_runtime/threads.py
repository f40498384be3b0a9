"""Driving several generators at once, in slices, at the pace of whoever takes what they yield."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import Generic, TypeVar

from .cancellation import heed, present_wishes

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


def side_by_side(
    tasks: Sequence[Steps[T]], width: int, sizes: Sequence[float] | None = None, room: float = math.inf
) -> Steps[T]:
    """All that the tasks yield, `width` of them at a time, each in its own order.

    A thread takes a task and goes on with it, slice by slice, until its end; no more than a slice ahead of who takes
    what the tasks yield. An exception in a task comes out here. When this generator ends or is closed, so have its
    threads: what they are at is stopped (see `ilf._runtime.cancellation`).

    Parameters
    ----------
    tasks : sequence of generator
        In the order in which they are begun, but for those that there is no room for at the time.
    width : int
        Number of threads.
    sizes : sequence of float, optional
        Of the tasks; none has any if left out.
    room : float
        A task is begun as long as the sizes of those under way add up to no more with it, or if there are none.
    """
    team = _Team(list(zip(sizes or [0.0] * len(tasks), tasks, strict=True)), width, room)
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

    def __init__(self, tasks: list[tuple[float, Steps[T]]], width: int, room: float) -> None:
        self._width = width
        self._tasks = tasks
        self._room = room
        self._under_way: list[float] = []
        self._taking = threading.Condition()
        self.stopped = threading.Event()
        self._ahead = threading.Semaphore(2 * width)
        # slices of items; what a thread ends with, None or what went wrong
        self._done = SimpleQueue[list[T] | BaseException | None]()

    def work(self) -> None:
        """What every thread does."""
        end: BaseException | None = None
        try:
            while (taken := self._next_task()) is not None:
                size, task = taken
                self._finish(task)
                self._make_room(size)
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
        with self._taking:
            self._taking.notify_all()

    def _next_task(self) -> tuple[float, Steps[T]] | None:
        with self._taking:
            while self._tasks and not self.stopped.is_set():
                taken = sum(self._under_way)
                for place, (size, _) in enumerate(self._tasks):
                    if not self._under_way or taken + size <= self._room:
                        self._under_way.append(size)
                        return self._tasks.pop(place)
                self._taking.wait()
            return None

    def _make_room(self, size: float) -> None:
        with self._taking:
            self._under_way.remove(size)
            self._taking.notify_all()

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
