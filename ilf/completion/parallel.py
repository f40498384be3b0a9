"""Running several generators in parallel threads, in time slices, at the pace of the consumer."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from queue import SimpleQueue
from typing import TypeVar

from .._runtime.cancellation import current_cancel_events, set_cancel_events
from .._runtime.threads import short_switches

T = TypeVar("T")
Steps = Generator[T, None, None]

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
