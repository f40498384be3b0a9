"""Waiting for the window in a real event loop, which leaves time to its threads, unlike a loop over `processEvents` or
QTest's wait."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QEventLoop, QTimer

_POLL_MS = 1
_LIMIT_S = 120


def pause(milliseconds: int) -> None:
    """Run the event loop for a while."""
    loop = QEventLoop()
    QTimer.singleShot(milliseconds, loop.quit)
    loop.exec()


def wait(reached: Callable[[], object]) -> None:
    """Run the event loop until a condition holds, even for a moment."""
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
        raise TimeoutError("the window did not reach the expected state")
