"""Work that stops soon after somebody has wished so: whoever does long work asks, now and then, whether it goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any, TypeVar

from ..errors import Cancelled

T = TypeVar("T")

_POLL_S = 0.02
"""How often whoever waits for others looks whether to go on waiting."""


class _Here(threading.local):
    """What is heeded in a thread."""

    wishes: tuple[threading.Event, ...] = ()


_here = _Here()


def present_wishes() -> tuple[threading.Event, ...]:
    """The wishes to stop that the work of this thread heeds, for threads that share it; see `heed`."""
    return _here.wishes


def heed(*wishes: threading.Event) -> None:
    """From now on, work in this thread stops when one of these events is set, and heeds no others."""
    _here.wishes = wishes


@contextmanager
def heeding(wish: threading.Event) -> Iterator[None]:
    """Within the block, work in this thread stops when the event is set, too.

    Examples
    --------
    >>> import threading
    >>> import ilf
    >>> frame = ilf.load_frame(ilf._runtime.installation.asset_path("samples/room"))
    >>> wish = threading.Event()
    >>> wish.set()  # from any thread
    >>> with heeding(wish):
    ...     ilf.extract_blocks(frame)
    Traceback (most recent call last):
    ilf.errors.Cancelled: The work was stopped.
    """
    before = _here.wishes
    _here.wishes = (*before, wish)
    try:
        yield
    finally:
        _here.wishes = before


def check_stopped() -> None:
    """Raise Cancelled if the work of this thread is to stop. It costs 0.1 us: call it every 50 ms of work or so."""
    if any(wish.is_set() for wish in _here.wishes):
        raise Cancelled("The work was stopped.")


def stoppable(items: Iterable[T]) -> Iterator[T]:
    """The same items; after each it is asked whether the work goes on."""
    for item in items:
        check_stopped()
        yield item


@contextmanager
def taking(lock: Any) -> Iterator[None]:
    """Hold a lock in the block; whoever waits for it stops waiting if the work is to stop."""
    while not lock.acquire(timeout=_POLL_S):
        check_stopped()
    try:
        yield
    finally:
        lock.release()


def out_of_signals_way(work: Callable[[], T]) -> T:
    """Do work that no exception may come into from outside: handlers of signals raise them in the main thread.

    There, it is done in a thread of its own, and stops when such an exception comes; elsewhere it is just done.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    left = threading.Event()
    wishes = (*present_wishes(), left)

    def heedful_work() -> T:
        heed(*wishes)
        return work()

    with ThreadPoolExecutor(1, "ilf-aside") as thread:
        try:
            future = thread.submit(heedful_work)
            while not future.done():  # a signal just before a wait without end would not be heard
                wait([future], _POLL_S)
            return future.result()
        finally:
            left.set()
