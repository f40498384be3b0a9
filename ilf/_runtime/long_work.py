"""Long work: regularly checked for cancellation, done in steps, for progress, and in threads beside each other."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from queue import SimpleQueue
from typing import Any, TypeVar

from ..errors import Cancelled

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")

Steps = Generator[T, None, None]

_POLL_S = 0.02
"""Interval at which waiting threads check for cancellation [s]."""


class _ThreadState(threading.local):
    """Cancellation events of a thread."""

    cancel_events: tuple[threading.Event, ...] = ()


_thread_state = _ThreadState()


def set_cancel_events(*cancel_events: threading.Event) -> None:
    """Set the cancellation events of this thread: its work stops when one of these is set, and no others count."""
    _thread_state.cancel_events = cancel_events


def cancelled_by(cancel_event: threading.Event) -> AbstractContextManager[None]:
    """Within the block, also cancel work in this thread when the event is set.

    Examples
    --------
    >>> import threading
    >>> import ilf
    >>> frame = ilf.load_frame(ilf._runtime.installation.asset_path("samples/room"))
    >>> cancel_event = threading.Event()
    >>> cancel_event.set()  # from any thread
    >>> with cancelled_by(cancel_event):
    ...     ilf.extract_blocks(frame)
    Traceback (most recent call last):
    ilf.errors.Cancelled: The work was cancelled.
    """
    return _cancelled_only_by(*_thread_state.cancel_events, cancel_event)


def not_cancelled() -> AbstractContextManager[None]:
    """Within the block, work in this thread that is short goes on to its end although it is cancelled."""
    return _cancelled_only_by()


@contextmanager
def _cancelled_only_by(*cancel_events: threading.Event) -> Iterator[None]:
    before = _thread_state.cancel_events
    set_cancel_events(*cancel_events)
    try:
        yield
    finally:
        set_cancel_events(*before)


def check_cancelled() -> None:
    """Raise Cancelled if the work of this thread has been cancelled. It costs 0.1 us: call it about every 50 ms."""
    if any(cancel_event.is_set() for cancel_event in _thread_state.cancel_events):
        raise Cancelled("The work was cancelled.")


def cancellable_items(items: Iterable[T]) -> Iterator[T]:
    """Yield the same items, checking for cancellation before each."""
    for item in items:
        check_cancelled()
        yield item


@contextmanager
def acquired(lock: Any) -> Iterator[None]:
    """Hold a lock within the block; waiting for it ends when the work is cancelled."""
    while not lock.acquire(timeout=_POLL_S):
        check_cancelled()
    try:
        yield
    finally:
        lock.release()


def run_aside(work: Callable[[], T], stop: Callable[[], None], seconds: float = math.inf) -> T:
    """Run work that cannot check for cancellation itself in a separate thread, and wait for its end.

    Parameters
    ----------
    work : callable
    stop : callable
        Makes the work end soon. It is called if this thread's work is cancelled, if the time is up, or if a signal
        handler raises an exception, which happens in the main thread.
    seconds : float
        Time limit; TimeoutError is raised then.
    """
    end = time.monotonic() + seconds
    with ThreadPoolExecutor(1, "ilf-aside") as thread:
        check_cancelled()
        try:
            future = thread.submit(work)
            while not future.done():  # a signal just before an endless wait would go unnoticed
                wait([future], _POLL_S)
                check_cancelled()
                if time.monotonic() > end and not future.done():
                    raise TimeoutError
        except BaseException:
            stop()
            raise
        return future.result()


# Work as a generator: steps, and a result at its end.


def run_to_end(steps: Generator[S, None, T], on_step: Callable[[S], object] | None = None) -> T:
    """Run all steps and return their result. An exception in `on_step` ends them."""
    told = mapped_steps(steps, on_step or (lambda step: None))
    while True:
        try:
            next(told)
        except StopIteration as end:
            result: T = end.value
            return result


def mapped_steps(steps: Generator[S, None, T], change: Callable[[S], R]) -> Generator[R, None, T]:
    """Yield the changed steps, and return their result."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            yield change(step)


# Threads beside each other: how many, how often they switch, and work in them, which is cancelled with that of the
# thread that starts them.

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
    events = _thread_state.cancel_events
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
    task is raised here. When this generator ends or is closed, its threads have ended: their work is cancelled.

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
        events = *_thread_state.cancel_events, stopped
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
