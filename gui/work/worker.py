"""The one worker pattern: a thread drives a generator, a timer brings what it yields to the GUI in batches."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from enum import Enum
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

DRAIN_INTERVAL_MS = 33
SHUTDOWN_LIMIT_S = 10.0


def _always(_: Any) -> bool:
    return True


class _Command(Enum):
    RUN = "run"
    PAUSE = "pause"
    STEP = "step"
    CANCEL = "cancel"


class Worker(QObject):
    """Drives one generator at a time, off the GUI's thread.

    What the generator yields comes in lists through `progressed`; its return value through `finished`; an
    exception through `failed`. After `cancel`, what was yielded before still comes, and then `cancelled`.
    All signals are emitted in the GUI's thread.
    """

    progressed = Signal(list)
    finished = Signal(object)
    failed = Signal(object)
    cancelled = Signal()
    paused = Signal()
    _told = Signal()
    """From the job's thread: the end, and what comes after a silence, is not left to wait for the timer."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._thread: threading.Thread | None = None
        self._state = threading.Condition()
        self._command = _Command.RUN
        self._waiting = False
        self._announced_pause = False
        self._items: deque[Any] = deque()
        self._end: tuple[str, Any] | None = None
        self._timer = QTimer(self, interval=DRAIN_INTERVAL_MS)
        self._timer.timeout.connect(self._drain)
        self._told.connect(self._drain, Qt.ConnectionType.QueuedConnection)

    @property
    def busy(self) -> bool:
        """Whether a job is under way, paused ones included."""
        return self._thread is not None

    @property
    def is_paused(self) -> bool:
        """Whether the job waits for `resume` or `step`."""
        return self.busy and self._command is _Command.PAUSE

    def start(
        self, job: Callable[[], Generator[Any, None, Any]], paused: bool = False, rests: Callable[[Any], bool] = _always
    ) -> None:
        """Run a job; RuntimeError if one is under way. With `paused`, it takes one step and waits.

        It waits after what `rests` says yes to; what it yields otherwise is part of a step.
        """
        if self.busy:
            raise RuntimeError("a job is under way")
        self._items.clear()
        self._end = None
        self._announced_pause = False
        self._command = _Command.STEP if paused else _Command.RUN
        self._thread = threading.Thread(target=self._drive, args=(job, rests), name="ilf-worker", daemon=True)
        self._thread.start()
        self._timer.start()

    def pause(self) -> None:
        """Wait after the present step."""
        self._order(_Command.PAUSE)

    def resume(self) -> None:
        """Go on after a pause."""
        self._order(_Command.RUN)

    def step(self) -> None:
        """One more step, then wait."""
        self._order(_Command.STEP)

    def cancel(self) -> None:
        """Stop after the present step; `cancelled` follows."""
        self._order(_Command.CANCEL)

    def shutdown(self) -> bool:
        """Cancel and wait for the thread, for a limited time. True if it has ended; no signal follows."""
        self._timer.stop()
        if self._thread is None:
            return True
        self._order(_Command.CANCEL)
        self._thread.join(SHUTDOWN_LIMIT_S)
        ended = not self._thread.is_alive()
        if ended:
            self._thread = None
        return ended

    def _order(self, command: _Command) -> None:
        with self._state:
            if self._command is not _Command.CANCEL:
                self._command = command
                self._announced_pause = False
            self._state.notify_all()

    def _drive(self, job: Callable[[], Generator[Any, None, Any]], rests: Callable[[Any], bool]) -> None:
        try:
            steps = job()
            silent_since, whole = -math.inf, True
            while self._may_go_on(whole):
                try:
                    item = next(steps)
                    self._items.append(item)
                    whole = rests(item)
                    now = time.monotonic()
                    if now - silent_since > DRAIN_INTERVAL_MS / 1000:
                        self._told.emit()
                    silent_since = now
                except StopIteration as stop:
                    self._end = "finished", stop.value
                    return
            steps.close()
            self._end = "cancelled", None
        except Exception as error:
            self._end = "failed", error
        finally:
            self._told.emit()

    def _may_go_on(self, whole: bool) -> bool:
        """Wait while paused, if the last step is whole; False once cancelled."""
        with self._state:
            while whole and self._command is _Command.PAUSE:
                self._waiting = True
                self._state.wait()
            self._waiting = False
            if self._command is _Command.STEP:
                self._command = _Command.PAUSE
            return self._command is not _Command.CANCEL

    def _drain(self) -> None:
        if self._thread is None:
            return
        end = self._end  # looked at first: what is in the buffer by then belongs before the end
        batch = [self._items.popleft() for _ in range(len(self._items))]
        if batch:
            self.progressed.emit(batch)
        if end is None:
            if self._waiting and not self._announced_pause and self.is_paused:
                self._announced_pause = True
                self.paused.emit()
            return
        self._timer.stop()
        thread, self._thread = self._thread, None
        if thread is None:  # who took the last batch has shut down
            return
        thread.join()
        kind, value = end
        self._end = None  # what the job gave is not kept by who made it
        if kind == "cancelled" or self._command is _Command.CANCEL:
            self.cancelled.emit()
        elif kind == "finished":
            self.finished.emit(value)
        else:
            self.failed.emit(value)
