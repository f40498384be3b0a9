"""Work that stops soon after somebody has wished so: whoever does long work asks, now and then, whether it goes on."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .errors import Cancelled

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
    >>> frame = ilf.load_frame(ilf.assets.asset_path("samples/room"))
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


@contextmanager
def taking(lock: Any) -> Iterator[None]:
    """Hold a lock in the block; whoever waits for it stops waiting if the work is to stop."""
    while not lock.acquire(timeout=_POLL_S):
        check_stopped()
    try:
        yield
    finally:
        lock.release()
