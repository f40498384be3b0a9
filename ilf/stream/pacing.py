"""The one way of pacing: items are taken at a rate, and of those that wait only the latest is kept."""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from itertools import pairwise
from typing import Generic, TypeVar

from .._runtime.cancellation import check_cancelled

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


class _Slot(Generic[T]):
    """A place for one item, which the next one replaces."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: list[T] = []
        self._dropped = 0
        self._error: BaseException | None = None
        self._ended = self._stopped = False

    def put(self, item: T) -> None:
        with self._changed:
            self._dropped += len(self._waiting)
            self._waiting = [item]
            self._changed.notify_all()

    def rest(self, seconds: float | None) -> bool:
        """Wait so long, or (None) until the item is taken; False once no more is wanted."""
        with self._changed:
            self._changed.wait_for(lambda: self._stopped or (seconds is None and not self._waiting), seconds)
            return not self._stopped

    def end(self, error: BaseException | None) -> None:
        with self._changed:
            self._error, self._ended = error, True
            self._changed.notify_all()

    def stop(self) -> None:
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def take(self) -> tuple[T, int] | None:
        """Wait for an item; return it, and how many were replaced since the last one; None after the last."""
        with self._changed:
            while not self._changed.wait_for(lambda: self._waiting or self._ended, _POLL_S):
                check_cancelled()
            if not self._waiting:
                if self._error is not None:
                    raise self._error
                return None
            dropped, self._dropped = self._dropped, 0
            self._changed.notify_all()
            return self._waiting.pop(), dropped


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
    slot = _Slot[T]()

    def take_items() -> None:
        error: BaseException | None = None
        try:
            due = time.monotonic()
            for item in items:
                slot.put(item)
                now, hertz = time.monotonic(), rate()
                due = now if hertz is None else max(due + 1 / hertz, now - 1 / hertz)
                if not slot.rest(None if hertz is None else max(0.0, due - now)):
                    break
        except BaseException as raised:  # passed to the waiting thread
            error = raised
        slot.end(error)

    thread = threading.Thread(target=take_items, name="ilf-frames")
    thread.start()
    try:
        while (taken := slot.take()) is not None:
            yield taken
    finally:
        slot.stop()
        thread.join()
