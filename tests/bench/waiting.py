"""Waiting for the window as a user does: its threads get to work meanwhile, as they do not in a loop that handles
events itself, nor in QTest's own wait."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QEventLoop, QTimer

_POLL_MS = 1
_LIMIT_S = 120


def pause(milliseconds: int) -> None:
    """Let the window work for a while."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


def wait(reached: Callable[[], object]) -> None:
    """Let the window work until something holds, if only for a moment."""
    deadline = time.perf_counter() + _LIMIT_S
    loop, timer = QEventLoop(), QTimer(interval=_POLL_MS)
    holds = False

    def look() -> None:
        nonlocal holds
        holds = bool(reached())
        if holds or time.perf_counter() > deadline:
            loop.quit()

    timer.timeout.connect(look)
    timer.start()
    loop.exec()
    timer.stop()
    if not holds:
        raise TimeoutError("the window has not come to what was waited for")
