"""Threads beside each other: how many, how often they switch, and work in one beside another."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from .cancellation import current_cancel_events, set_cancel_events

T = TypeVar("T")

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
