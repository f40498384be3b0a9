"""The one way of pacing: items are taken at a rate, and of those that wait only the latest is kept."""

from __future__ import annotations

import queue
import statistics
import threading
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import suppress
from itertools import pairwise
from typing import TypeVar

from .._runtime.long_work import check_cancelled

T = TypeVar("T")

USUAL_RATE = 10.0
"""Frames a second of a source without timestamps, and of a camera."""

_POLL_S = 0.05
"""Interval [s] of checks for cancellation while no item comes."""


def rate_of(times: Sequence[float | None]) -> float:
    """Return the frames a second of a source from the times [s] of its frames, as far as they are known.

    Examples
    --------
    >>> rate_of([0.0, 0.5, 1.0, None, 7.0]), rate_of([])
    (2.0, 10.0)
    """
    gaps = [later - time for time, later in pairwise(times) if time is not None and later is not None and later > time]
    return 1 / statistics.median(gaps) if gaps else USUAL_RATE


def measured_rate(moments: Sequence[float]) -> float:
    """Return the frames a second from the moments [s] at which the latest were shown; 0 for less than two."""
    passed = moments[-1] - moments[0] if moments else 0.0
    return (len(moments) - 1) / passed if passed > 0 else 0.0


def latest_of(items: Iterable[T], rate: Callable[[], float | None]) -> Generator[tuple[T, int], None, None]:
    """Take items in a thread, and yield the latest with the number of those left out before it. Close it to end the
    thread, which waits for the item that it is taking.

    Parameters
    ----------
    items : iterable
    rate : callable
        Gives the present rate, in items a second; None for as many as are wanted, of which none is left out.

    Examples
    --------
    >>> list(latest_of("ilf", lambda: None))
    [('i', 0), ('l', 0), ('f', 0)]
    """
    waiting: queue.Queue[tuple[T, int] | BaseException | None] = queue.Queue(1)
    stopped = threading.Event()

    def take_items() -> None:
        end: BaseException | None = None
        try:
            due = time.monotonic()
            for item in items:
                hertz, dropped = rate(), 0
                with suppress(queue.Empty):
                    if hertz is not None and isinstance(before := waiting.get_nowait(), tuple):
                        dropped = before[1] + 1
                waiting.put((item, dropped))
                now = time.monotonic()
                due = now if hertz is None else max(due + 1 / hertz, now - 1 / hertz)
                if stopped.wait(max(0.0, due - now)):
                    return
        except BaseException as raised:  # passed to the waiting thread
            end = raised
        waiting.put(end)

    thread = threading.Thread(target=take_items, name="ilf-frames")
    thread.start()
    try:
        while True:
            try:
                taken = waiting.get(timeout=_POLL_S)
            except queue.Empty:
                check_cancelled()
                continue
            if isinstance(taken, BaseException):
                raise taken
            if taken is None:
                return
            yield taken
    finally:
        stopped.set()
        with suppress(queue.Empty):
            waiting.get_nowait()  # which the thread may be waiting for
        thread.join()
