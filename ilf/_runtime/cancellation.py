"""Long work: it regularly checks whether it has been cancelled, or is done in steps, for progress."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, closing, contextmanager
from typing import Any, TypeVar

from ..errors import Cancelled

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")

_POLL_S = 0.02
"""Interval at which waiting threads check for cancellation [s]."""


class _ThreadState(threading.local):
    """Cancellation events of a thread."""

    cancel_events: tuple[threading.Event, ...] = ()


_thread_state = _ThreadState()


def current_cancel_events() -> tuple[threading.Event, ...]:
    """Return the cancellation events of this thread, to pass them to threads that share its work; see
    `set_cancel_events`."""
    return _thread_state.cancel_events


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
    return _cancelled_only_by(*current_cancel_events(), cancel_event)


def not_cancelled() -> AbstractContextManager[None]:
    """Within the block, work in this thread that is short goes on to its end although it is cancelled."""
    return _cancelled_only_by()


@contextmanager
def _cancelled_only_by(*cancel_events: threading.Event) -> Iterator[None]:
    before = current_cancel_events()
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
