"""Background workers: a thread drives a generator, a timer passes its items to the GUI in batches."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from enum import Enum
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from ilf._runtime.long_work import available_cores, set_cancel_events

DRAIN_INTERVAL_MS = 33

# A thread that drives a generator and can be paused, stepped and cancelled.

Make = Callable[[], Generator[Any, None, Any]]


class Order(Enum):
    """An order to a job."""

    RUN = "run"
    PAUSE = "pause"
    STEP = "step"
    CANCEL = "cancel"


PAUSED = object()


class JobThread:
    """A thread that drives a generator to its end, under commands.

    Parameters
    ----------
    make : callable
        Returns the generator; called in the thread.
    command : Order
        The first command.
    is_step_end : callable
        Given a yielded item, returns whether the job may pause after it.
    notify : callable
        Called in the thread when it ends, and when an item is yielded after a silence.
    interruptible : bool
        Whether the current step is interrupted when the job is cancelled.

    Attributes
    ----------
    items : deque
        Items that were yielded and not fetched yet, with `PAUSED` where it pauses.
    end : tuple of str and object, or None
        "finished" and the generator's return value, "failed" and an exception, or "cancelled".
    command : Order
        The last command.
    """

    def __init__(
        self,
        make: Make,
        command: Order,
        is_step_end: Callable[[Any], bool],
        notify: Callable[[], None],
        interruptible: bool,
    ) -> None:
        self.items: deque[Any] = deque()
        self.end: tuple[str, Any] | None = None
        self._make, self._is_step_end, self._notify = make, is_step_end, notify
        self._interruptible = interruptible
        self.command = command
        self._cancel_event = threading.Event()
        self._state = threading.Condition()
        self._notify_lock = threading.Lock()
        self._attached = True
        self._thread = threading.Thread(target=self._drive, name="ilf-worker", daemon=True)
        self._thread.start()

    def order(self, command: Order) -> None:
        """Set the command, unless the job was cancelled before."""
        with self._state:
            if self.command is not Order.CANCEL:
                self.command = command
            self._state.notify_all()
        if command is Order.CANCEL and self._interruptible:
            self._cancel_event.set()

    def detach(self) -> None:
        """Detach the job: it ends by itself and no longer reports."""
        with self._notify_lock:
            self._attached = False

    def join(self, limit: float | None = None) -> bool:
        """Wait for the thread, for at most `limit` seconds; True if it has ended."""
        self._thread.join(limit)
        return not self._thread.is_alive()

    def _drive(self) -> None:
        set_cancel_events(self._cancel_event)
        try:
            self.end = self._driven()
        except Exception as error:
            self.end = "failed", error
        except BaseException as error:  # such as SystemExit: the end must still be reported
            failure = RuntimeError(f"The work was ended by {error!r}.")
            failure.__cause__ = error
            self.end = "failed", failure
        finally:
            self._notify_listener()

    def _driven(self) -> tuple[str, Any]:
        steps = self._make()
        silent_since, step_done = -math.inf, True
        while self._wait_for_command(step_done):
            try:
                item = next(steps)
            except StopIteration as stop:
                return "finished", stop.value
            self.items.append(item)
            step_done = self._is_step_end(item)
            now = time.monotonic()
            if now - silent_since > DRAIN_INTERVAL_MS / 1000:
                self._notify_listener()
            silent_since = now
        steps.close()
        return "cancelled", None

    def _notify_listener(self) -> None:
        with self._notify_lock:
            if self._attached:
                self._notify()

    def _wait_for_command(self, step_done: bool) -> bool:
        """Wait while paused, if the last step is complete; False once cancelled."""
        with self._state:
            while step_done and self.command is Order.PAUSE:
                self.items.append(PAUSED)
                self._state.wait()
            if self.command is Order.STEP:
                self.command = Order.PAUSE
            return self.command is not Order.CANCEL


DETACH_MS = 100
"""Time [ms] to wait for a cancelled job; a busy library cannot be interrupted."""
SHUTDOWN_LIMIT_S = 0.1
"""The same [s] when the window closes."""
FINISH_LIMIT_S = 10.0
"""The same [s] for a job that must finish."""


class Worker(QObject):
    """Drives one generator at a time in a background thread.

    Yielded items are emitted in lists by `progressed`, the return value by `finished`, an exception by `failed`. After
    `cancel`, remaining items are emitted, and soon after `cancelled`, even if the thread cannot be interrupted; the
    thread is then detached and no longer reports. All signals are emitted in the GUI's thread.

    Parameters
    ----------
    must_finish : bool
        Whether the current step is always finished and waited for, as writing to disk must be.
    """

    progressed = Signal(list)
    finished = Signal(object)
    failed = Signal(object)
    cancelled = Signal()
    paused = Signal()
    _wake = Signal()
    """From the job's thread: its end, and items after a silence, do not wait for the timer."""

    def __init__(self, parent: QObject | None = None, must_finish: bool = False) -> None:
        super().__init__(parent)
        self._must_finish = must_finish
        self._job: JobThread | None = None
        self._timer = QTimer(self, interval=DRAIN_INTERVAL_MS)
        self._timer.timeout.connect(self._drain)
        self._patience = QTimer(self, singleShot=True, interval=DETACH_MS)
        self._patience.timeout.connect(self._detach)
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(self.cancel)
        self._wake.connect(self._drain, Qt.ConnectionType.QueuedConnection)

    @property
    def busy(self) -> bool:
        """Whether a job is in progress, paused ones included."""
        return self._job is not None

    @property
    def is_paused(self) -> bool:
        """Whether the job waits for another command."""
        return self._job is not None and self._job.command is Order.PAUSE

    def start(self, job: Make, paused: bool = False, is_step_end: Callable[[Any], bool] = lambda _: True) -> None:
        """Start a job; RuntimeError if one is in progress. With `paused`, it pauses after one step.

        A step ends with an item for which `is_step_end` returns True.
        """
        if self.busy:
            raise RuntimeError("a job is already in progress")
        command = Order.STEP if paused else Order.RUN
        self._job = JobThread(job, command, is_step_end, self._wake.emit, interruptible=not self._must_finish)
        self._timer.start()

    def order(self, command: Order) -> None:
        """Pause the job after the current step, run it on, or run one more step and pause."""
        if self._job is not None:
            self._job.order(command)

    def cancel(self, after_ms: int = 0) -> None:
        """Cancel the job, at once, or after a time that a later call does not extend; `cancelled` follows."""
        if after_ms:
            if not self._later.isActive():
                self._later.start(after_ms)
            return
        self._later.stop()
        self.order(Order.CANCEL)
        if self.busy and not self._must_finish and not self._patience.isActive():
            self._patience.start()

    def shutdown(self) -> bool:
        """Cancel and wait for the thread, for a limited time. True if it has ended; no signal of it follows."""
        job = self._job
        self._forget()
        if job is None:
            return True
        job.detach()
        job.order(Order.CANCEL)
        return job.join(FINISH_LIMIT_S if self._must_finish else SHUTDOWN_LIMIT_S)

    def _drain(self) -> None:
        job = self._job
        if job is None:
            return
        end = job.end  # read first: items in the buffer by then belong before the end
        self._pass_on(job)
        if end is not None and self._job is job:  # a receiver of the last batch may have shut down
            job.join()
            self._forget()
            kind, value = end
            if kind == "cancelled" or job.command is Order.CANCEL:
                self.cancelled.emit()
            elif kind == "finished":
                self.finished.emit(value)
            else:
                self.failed.emit(value)

    def _detach(self) -> None:
        """Detach a cancelled job that does not end."""
        job = self._job
        if job is None:
            return
        job.detach()
        self._pass_on(job)
        if self._job is job:
            self._forget()
            self.cancelled.emit()

    def _pass_on(self, job: JobThread) -> None:
        batch = [job.items.popleft() for _ in range(len(job.items))]
        items = [item for item in batch if item is not PAUSED]
        if items:
            self.progressed.emit(items)
        if len(items) < len(batch) and self.is_paused:
            self.paused.emit()

    def _forget(self) -> None:
        for timer in (self._timer, self._patience, self._later):
            timer.stop()
        self._job = None


def stop_workers(owner: QObject) -> bool:
    """Stop all workers of an object and its children, before it is closed. True if their threads have ended."""
    ended = [worker.shutdown() for worker in owner.findChildren(Worker)]
    return all(ended)


# Estimate of the remaining time.

_MIN_ELAPSED_S = 1.0
_MIN_SHARE = 0.02
_STEPS = ((10, 1), (60, 5))
"""(limit, step) [s]: rounding of times up to a limit; longer times are in minutes."""


class Pace:
    """Estimates the remaining time of some work from the share that is done and the time spent, without pauses.

    Parameters
    ----------
    clock : callable
        Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._share = self._elapsed = 0.0
        self._last: float | None = None

    def note(self, share: float, going: bool = True) -> None:
        """Note the share done, 0-1; `going` is False while paused. A smaller share than before starts new work."""
        now = self._clock()
        if share < self._share:
            self._elapsed, self._last = 0.0, None
        if self._last is not None:
            self._elapsed += now - self._last
        self._share = share
        self._last = now if going else None

    def forget(self) -> None:
        """Reset after the work has ended."""
        self._share, self._elapsed, self._last = 0.0, 0.0, None

    @property
    def left(self) -> float | None:
        """Remaining time [s]; None while it cannot be estimated."""
        if self._elapsed < _MIN_ELAPSED_S or not _MIN_SHARE <= self._share < 1:
            return None
        return self._elapsed * (1 - self._share) / self._share

    def text(self) -> str:
        """Return the rounded remaining time, as "12 s left"; "" while it cannot be estimated."""
        left = self.left
        if left is None:
            return ""
        for limit, step in _STEPS:
            rounded = max(math.ceil(left / step), 1) * step
            if rounded <= limit:
                return f"{rounded} s left"
        return f"{math.ceil(left / 60)} min left"


# Number of threads for long work.


def spare_cores() -> int:
    """Return the number of threads for background work, at least one: one core is left to the window."""
    return max(available_cores() - 1, 1)
