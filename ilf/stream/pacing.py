"""Taking items at a rate, of which only the latest waits."""

from __future__ import annotations

import threading
import time
from collections.abc import Generator, Iterable
from typing import Generic, TypeVar

from .._runtime.cancellation import check_cancelled

T = TypeVar("T")

_POLL_S = 0.05
"""Interval [s] of checks for cancellation while no item comes."""


class _Slot(Generic[T]):
    """A place for one item, which the next one replaces."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._waiting: list[T] = []
        self._dropped = 0
        self._end: BaseException | None = None
        self._ended = False

    def put(self, item: T) -> None:
        with self._changed:
            self._dropped += len(self._waiting)
            self._waiting = [item]
            self._changed.notify()

    def end(self, error: BaseException | None) -> None:
        with self._changed:
            self._end, self._ended = error, True
            self._changed.notify()

    def take(self) -> tuple[T, int] | None:
        """Wait for an item; return it, and how many were replaced since the last one; None after the last."""
        with self._changed:
            while not self._changed.wait_for(lambda: self._waiting or self._ended, _POLL_S):
                check_cancelled()
            if not self._waiting:
                if self._end is not None:
                    raise self._end
                return None
            dropped, self._dropped = self._dropped, 0
            return self._waiting.pop(), dropped


def latest_of(items: Iterable[T], rate: float) -> Generator[tuple[T, int], None, None]:
    """Take items in a thread, at most `rate` a second, and yield the latest with the number of those left out before
    it. Close it to end the thread, which waits for the item that it is taking.

    Examples
    --------
    >>> list(latest_of([1], rate=10))
    [(1, 0)]
    """
    slot, stopped = _Slot[T](), threading.Event()

    def take_items() -> None:
        error: BaseException | None = None
        try:
            due = time.monotonic()
            for item in items:
                slot.put(item)
                due = max(due + 1 / rate, time.monotonic() - 1 / rate)
                if stopped.wait(max(0.0, due - time.monotonic())):
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
        stopped.set()
        thread.join()
