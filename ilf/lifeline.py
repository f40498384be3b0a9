"""How a process notices that whoever began it has ended: a pipe on which nothing is sent closes then."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress

from .unfinished import discard_unfinished


def live_by(closed: Callable[[], object]) -> None:
    """Called in a process that has just begun: it ends when something returns, or raises EOFError or OSError, as
    reading from a pipe does whose other end is only in the process that began this one."""
    # Ctrl+C reaches every process of a terminal; it is answered once, by whoever began them
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(closed,), name="ilf-lifeline", daemon=True).start()


def _end_with(closed: Callable[[], object]) -> None:
    with suppress(EOFError, OSError):
        closed()
    discard_unfinished()
    os._exit(1)
