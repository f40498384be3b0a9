"""Running several generators in parallel threads, in time slices, at the pace of the consumer."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue
from typing import Generic, TypeVar

from .cancellation import current_cancel_events, set_cancel_events

T = TypeVar("T")
Steps = Generator[T, None, None]

SLICE_S = 0.005
"""Time slice of a thread [s]: for steps of microseconds, switching would cost more than the work."""

_SWITCH_S = 0.0002
"""Switch interval of the interpreter's lock [s]. Python's default of 5 ms is longer than most work that threads do
without the lock: one thread would idle while another acquires it again and again."""


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_in_parallel(
    tasks: Sequence[Steps[T]], width: int, sizes: Sequence[float] | None = None, room: float = math.inf
) -> Steps[T]:
    """Yield the items of all tasks, running `width` of them in parallel, each in its own order.

    Each thread runs one task to its end, slice by slice, at most one slice ahead of the consumer. An exception in a
    task is raised here. When this generator ends or is closed, its threads have ended: their work is cancelled (see
    `ilf._runtime.cancellation`).

    Parameters
    ----------
    tasks : sequence of generator
        Started in this order, except for those that do not fit into `room` at the time.
    width : int
        Number of threads.
    sizes : sequence of float, optional
        Size of each task; 0 if omitted.
    room : float
        A task starts only if the total size of running tasks stays within this limit, or if none is running.
    """
    worker_pool = _WorkerPool(list(zip(sizes or [0.0] * len(tasks), tasks, strict=True)), width, room)
    cancel_events = *current_cancel_events(), worker_pool.stopped
    pool = ThreadPoolExecutor(
        width, thread_name_prefix="ilf-block", initializer=set_cancel_events, initargs=cancel_events
    )
    with short_switches():
        try:
            for _ in range(width):
                pool.submit(worker_pool.work)
            yield from worker_pool.results()
        finally:
            worker_pool.stop()
            pool.shutdown()


_sharing = threading.Lock()
_intervals: list[float] = []
"""The usual switch interval, once for each block that shortens it at present."""


@contextmanager
def short_switches() -> Iterator[None]:
    """Shorten the switch interval of the interpreter's lock, for work in a thread beside others that must not wait."""
    with _sharing:
        _intervals.append(_intervals[0] if _intervals else sys.getswitchinterval())
        sys.setswitchinterval(min(_SWITCH_S, _intervals[0]))
    try:
        yield
    finally:
        with _sharing:
            usual = _intervals.pop()
            if not _intervals:
                sys.setswitchinterval(usual)


@contextmanager
def run_beside(work: Callable[[], T]) -> Iterator[Future[T]]:
    """Run work in a thread of its own beside the block, at whose end it is waited for, and its exception raised."""
    events = current_cancel_events()
    with short_switches(), ThreadPoolExecutor(1, "ilf-beside", set_cancel_events, events) as thread:
        future = thread.submit(work)
        yield future
        future.result()


class _WorkerPool(Generic[T]):
    """Threads that share tasks, and the queue of their results."""

    def __init__(self, tasks: list[tuple[float, Steps[T]]], width: int, room: float) -> None:
        self._width = width
        self._tasks = tasks
        self._room = room
        self._under_way: list[float] = []
        self._tasks_changed = threading.Condition()
        self.stopped = threading.Event()
        self._ahead = threading.Semaphore(2 * width)
        # slices of items; at the end of a thread, None or its error
        self._done = SimpleQueue[list[T] | BaseException | None]()

    def work(self) -> None:
        """Run tasks until none is left; the body of every thread."""
        end: BaseException | None = None
        try:
            while (taken := self._next_task()) is not None:
                size, task = taken
                self._finish(task)
                self._make_room(size)
        except BaseException as error:  # passed to the waiting thread
            end = error
        self._done.put(end)

    def results(self) -> Steps[T]:
        """Yield the items of the tasks as they arrive."""
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
        """End the threads at the next item of their tasks."""
        self.stopped.set()
        self._ahead.release(self._width)
        with self._tasks_changed:
            self._tasks_changed.notify_all()

    def _next_task(self) -> tuple[float, Steps[T]] | None:
        with self._tasks_changed:
            while self._tasks and not self.stopped.is_set():
                taken = sum(self._under_way)
                for place, (size, _) in enumerate(self._tasks):
                    if not self._under_way or taken + size <= self._room:
                        self._under_way.append(size)
                        return self._tasks.pop(place)
                self._tasks_changed.wait()
            return None

    def _make_room(self, size: float) -> None:
        with self._tasks_changed:
            self._under_way.remove(size)
            self._tasks_changed.notify_all()

    def _finish(self, task: Steps[T]) -> None:
        ended = False
        while not ended:
            self._ahead.acquire()
            if self.stopped.is_set():
                return
            items, ended = self._slice(task)
            self._done.put(items)

    def _slice(self, task: Steps[T]) -> tuple[list[T], bool]:
        """Return the items of a task's next slice, and whether the task has ended."""
        items: list[T] = []
        end = time.perf_counter() + SLICE_S
        for item in task:
            items.append(item)
            if self.stopped.is_set() or time.perf_counter() >= end:
                return items, False
        return items, True
