"""Threads beside each other: how many, how often they switch, work in one beside another, and generators in parallel at
the pace of their consumer."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from queue import SimpleQueue
from typing import TypeVar

from .cancellation import current_cancel_events, set_cancel_events

T = TypeVar("T")
Steps = Generator[T, None, None]

_SWITCH_S = 0.0002
"""Switch interval of the interpreter's lock [s]. Python's default of 5 ms is longer than most work that threads do
without the lock: one thread would idle while another acquires it again and again."""


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


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


# Several generators in parallel, in time slices.

SLICE_S = 0.005
"""Time slice of a thread [s]: for steps of microseconds, switching would cost more than the work."""


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
    waiting = list(zip(sizes or [0.0] * len(tasks), tasks, strict=True))
    done = SimpleQueue[list[T] | Future[None]]()  # slices of items; at the end of a task, its future
    ahead, stopped = threading.Semaphore(2 * width), threading.Event()

    def work(task: Steps[T]) -> None:
        ended = False
        while not ended:
            ahead.acquire()
            if stopped.is_set():
                return
            items, ended = _slice(task, stopped)
            done.put(items)

    with ExitStack() as at_end:
        at_end.enter_context(short_switches())
        events = *current_cancel_events(), stopped
        threads = at_end.enter_context(ThreadPoolExecutor(width, "ilf-block", set_cancel_events, events))
        at_end.callback(ahead.release, 2 * width)
        at_end.callback(stopped.set)
        under_way: dict[Future[None], float] = {}
        while waiting or under_way:
            while len(under_way) <= width:  # one more than threads, so that none waits for the consumer
                free = room - sum(under_way.values()) if under_way else math.inf
                fitting = next((one for one in waiting if one[0] <= free), None)
                if fitting is None:
                    break
                waiting.remove(fitting)
                future = threads.submit(work, fitting[1])
                under_way[future] = fitting[0]
                future.add_done_callback(done.put)
            found = done.get()
            if isinstance(found, Future):
                del under_way[found]
                found.result()
            else:
                ahead.release()
                yield from found


def _slice(task: Steps[T], stopped: threading.Event) -> tuple[list[T], bool]:
    """Return the items of a task's next slice, and whether the task has ended."""
    items: list[T] = []
    end = time.perf_counter() + SLICE_S
    for item in task:
        items.append(item)
        if stopped.is_set() or time.perf_counter() >= end:
            return items, False
    return items, True
