"""Driving several generators at once, in slices, at the pace of whoever takes what they yield."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import nullcontext
from typing import Generic, TypeVar

from .stopping import heed, present_wishes

T = TypeVar("T")
Steps = Generator[T, None, None]

SLICE_S = 0.005
"""Seconds of work that are handed to a thread at a time: steps of microseconds drown in the handing over."""

TINY_STEP_S = 0.00015
"""Computing time of a step below which two threads together were found to be slower than one."""


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

    An exception in a task comes out here. When this generator ends or is closed, so have its threads: what they are at
    is stopped (see `ilf.stopping`).

    Parameters
    ----------
    tasks : sequence of generator
        In the order in which they are begun.
    width : int
        Number of threads.
    """
    stopped, turn = threading.Event(), threading.Lock()
    waiting = (_Sliced(task, stopped, turn) for task in tasks)
    pool = ThreadPoolExecutor(
        width, thread_name_prefix="ilf-block", initializer=heed, initargs=(*present_wishes(), stopped)
    )
    slices: dict[Future[tuple[list[T], bool]], _Sliced[T]] = {}

    def go_on(task: _Sliced[T] | None) -> None:
        if task is not None:
            slices[pool.submit(task.advance)] = task

    try:
        for _ in range(width):
            go_on(next(waiting, None))
        while slices:
            for done in wait(slices, return_when=FIRST_COMPLETED).done:
                task = slices.pop(done)
                items, ended = done.result()
                go_on(next(waiting, None) if ended else task)
                yield from items
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


class _Sliced(Generic[T]):
    """A task that goes on for a short while at a time, each time in any thread.

    Tasks of tiny steps take turns: two of them would spend more on passing the interpreter's lock to and fro than
    they gain, while set-ups and large steps, which do without it, run beside them.
    """

    def __init__(self, task: Steps[T], stopped: threading.Event, turn: threading.Lock) -> None:
        self._task = task
        self._stopped = stopped
        self._turn = turn
        self._tiny = False

    def advance(self) -> tuple[list[T], bool]:
        """What the task yields in a slice, and whether that was its end."""
        with self._turn if self._tiny else nullcontext():
            items: list[T] = []
            begun = 0.0
            end = time.perf_counter() + SLICE_S
            for item in self._task:
                items.append(item)
                if len(items) == 1:  # it may hold a set-up
                    begun = time.thread_time()
                if self._stopped.is_set() or time.perf_counter() >= end:
                    break
            else:
                return items, True
            if len(items) > 1:
                self._tiny = time.thread_time() - begun < TINY_STEP_S * (len(items) - 1)
            return items, False
