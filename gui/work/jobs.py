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

from ilf._runtime.cancellation import heed
from ilf._runtime.threads import available_cores

# A generator that is driven in a thread of its own, at the pace that somebody orders.

Make = Callable[[], Generator[Any, None, Any]]


class Command(Enum):
    """What a job is to do."""

    RUN = "run"
    PAUSE = "pause"
    STEP = "step"
    CANCEL = "cancel"


class JobThread:
    """Drives a generator to its end, or as far as it is ordered to.

    Parameters
    ----------
    make : callable
        Gives the generator; called in the thread.
    command : Command
        The first.
    rests : callable
        Takes what the generator has yielded, and says whether the job may pause after it.
    tell : callable
        Called in the thread when it has ended, and when something has been yielded after a silence.
    silence : float
        How long that is [s].
    stoppable : bool
        Whether a step that is under way stops when the job is cancelled.

    Attributes
    ----------
    items : deque
        What has been yielded and not taken yet.
    end : tuple of str and object, or None
        "finished" and what the generator has returned, "failed" and an exception, or "cancelled".
    waiting : bool
        Whether it is paused, in fact.
    """

    def __init__(
        self,
        make: Make,
        command: Command,
        rests: Callable[[Any], bool],
        tell: Callable[[], None],
        silence: float,
        stoppable: bool,
    ) -> None:
        self.items: deque[Any] = deque()
        self.end: tuple[str, Any] | None = None
        self.waiting = False
        self._make, self._rests, self._tell, self._silence = make, rests, tell, silence
        self._stoppable = stoppable
        self._command = command
        self._wish = threading.Event()
        self._state = threading.Condition()
        self._listening = threading.Lock()
        self._heard = True
        self._thread = threading.Thread(target=self._drive, name="ilf-worker", daemon=True)
        self._thread.start()

    @property
    def command(self) -> Command:
        """The last order."""
        return self._command

    def order(self, command: Command) -> bool:
        """Do this from now on; False if the job has been cancelled before."""
        with self._state:
            obeyed = self._command is not Command.CANCEL
            if obeyed:
                self._command = command
            self._state.notify_all()
        if command is Command.CANCEL and self._stoppable:
            self._wish.set()
        return obeyed

    def leave(self) -> None:
        """Let it end by itself: it tells nothing any more."""
        with self._listening:
            self._heard = False

    def join(self, limit: float | None = None) -> bool:
        """Wait for the thread, for so many seconds at most; whether it has ended."""
        self._thread.join(limit)
        return not self._thread.is_alive()

    def _drive(self) -> None:
        heed(self._wish)
        try:
            self.end = self._driven()
        except Exception as error:
            self.end = "failed", error
        except BaseException as error:  # SystemExit, say: whoever waits for the job is to hear of its end
            failure = RuntimeError(f"The work has ended by {error!r}.")
            failure.__cause__ = error
            self.end = "failed", failure
        finally:
            self._say()

    def _driven(self) -> tuple[str, Any]:
        steps = self._make()
        silent_since, whole = -math.inf, True
        while self._may_go_on(whole):
            try:
                item = next(steps)
            except StopIteration as stop:
                return "finished", stop.value
            self.items.append(item)
            whole = self._rests(item)
            now = time.monotonic()
            if now - silent_since > self._silence:
                self._say()
            silent_since = now
        steps.close()
        return "cancelled", None

    def _say(self) -> None:
        with self._listening:
            if self._heard:
                self._tell()

    def _may_go_on(self, whole: bool) -> bool:
        """Wait while paused, if the last step is whole; False once cancelled."""
        with self._state:
            while whole and self._command is Command.PAUSE:
                self.waiting = True
                self._state.wait()
            self.waiting = False
            if self._command is Command.STEP:
                self._command = Command.PAUSE
            return self._command is not Command.CANCEL


DRAIN_INTERVAL_MS = 33
LET_GO_MS = 100
"""How long a job that was cancelled is waited for; a library that is busy hears nothing meanwhile."""
SHUTDOWN_LIMIT_S = 0.1
"""The same when the window closes."""
FINISH_LIMIT_S = 10.0
"""The same of a job that is to finish."""


def _always(_: Any) -> bool:
    return True


class Worker(QObject):
    """Drives one generator at a time, off the GUI's thread.

    What the generator yields comes in lists through `progressed`; its return value through `finished`; whatever it
    ends by otherwise through `failed`. After `cancel`, what was yielded before still comes, and then `cancelled`: very
    soon, also if the thread is in the middle of something that cannot be stopped. It is left alone then, and nothing is
    heard of it any more. All signals are emitted in the GUI's thread.

    Parameters
    ----------
    finishes : bool
        Whether a step that is under way is finished in any case, and waited for: what is stored has to be.
    """

    progressed = Signal(list)
    finished = Signal(object)
    failed = Signal(object)
    cancelled = Signal()
    paused = Signal()
    _told = Signal()
    """From the job's thread: the end, and what comes after a silence, is not left to wait for the timer."""

    def __init__(self, parent: QObject | None = None, finishes: bool = False) -> None:
        super().__init__(parent)
        self._finishes = finishes
        self._job: JobThread | None = None
        self._announced_pause = False
        self._timer = QTimer(self, interval=DRAIN_INTERVAL_MS)
        self._timer.timeout.connect(self._drain)
        self._patience = QTimer(self, singleShot=True, interval=LET_GO_MS)
        self._patience.timeout.connect(self._let_go)
        self._told.connect(self._drain, Qt.ConnectionType.QueuedConnection)

    @property
    def busy(self) -> bool:
        """Whether a job is under way, paused ones included."""
        return self._job is not None

    @property
    def is_paused(self) -> bool:
        """Whether the job waits for `resume` or `step`."""
        return self._job is not None and self._job.command is Command.PAUSE

    def start(self, job: Make, paused: bool = False, rests: Callable[[Any], bool] = _always) -> None:
        """Run a job; RuntimeError if one is under way. With `paused`, it takes one step and waits.

        It waits after what `rests` says yes to; what it yields otherwise is part of a step.
        """
        if self.busy:
            raise RuntimeError("a job is under way")
        self._announced_pause = False
        command = Command.STEP if paused else Command.RUN
        silence = DRAIN_INTERVAL_MS / 1000
        self._job = JobThread(job, command, rests, self._told.emit, silence, stoppable=not self._finishes)
        self._timer.start()

    def pause(self) -> None:
        """Wait after the present step."""
        self._order(Command.PAUSE)

    def resume(self) -> None:
        """Go on after a pause."""
        self._order(Command.RUN)

    def step(self) -> None:
        """One more step, then wait."""
        self._order(Command.STEP)

    def cancel(self) -> None:
        """Stop; `cancelled` follows."""
        self._order(Command.CANCEL)
        if self.busy and not self._finishes and not self._patience.isActive():
            self._patience.start()

    def shutdown(self) -> bool:
        """Cancel and wait for the thread, for a limited time. True if it has ended; no signal follows."""
        self._timer.stop()
        self._patience.stop()
        if self._job is None:
            return True
        self._job.leave()
        self._job.order(Command.CANCEL)
        ended = self._job.join(FINISH_LIMIT_S if self._finishes else SHUTDOWN_LIMIT_S)
        if ended:
            self._job = None
        return ended

    def _order(self, command: Command) -> None:
        if self._job is not None and self._job.order(command):
            self._announced_pause = False

    def _drain(self) -> None:
        job = self._job
        if job is None:
            return
        end = job.end  # looked at first: what is in the buffer by then belongs before the end
        self._pass_on(job)
        if end is None:
            if job.waiting and not self._announced_pause and self.is_paused:
                self._announced_pause = True
                self.paused.emit()
        elif self._job is job:  # who took the last batch may have shut down
            job.join()
            self._forget()
            kind, value = end
            if kind == "cancelled" or job.command is Command.CANCEL:
                self.cancelled.emit()
            elif kind == "finished":
                self.finished.emit(value)
            else:
                self.failed.emit(value)

    def _let_go(self) -> None:
        """It has been cancelled, and does not end."""
        job = self._job
        if job is None:
            return
        job.leave()
        self._pass_on(job)
        if self._job is job:
            self._forget()
            self.cancelled.emit()

    def _pass_on(self, job: JobThread) -> None:
        batch = [job.items.popleft() for _ in range(len(job.items))]
        if batch:
            self.progressed.emit(batch)

    def _forget(self) -> None:
        self._timer.stop()
        self._patience.stop()
        self._job = None


# How long what is under way will still take.

_NOT_BEFORE_S = 1.0
_LEAST_SHARE = 0.02
_STEPS = ((10, 1), (60, 5))
"""Up to so many seconds, in steps of so many; above, in minutes."""


class Pace:
    """Estimates the rest of some work from the share that is done and the time that it was really going.

    Parameters
    ----------
    clock : callable
        Gives seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._share = self._gone = 0.0
        self._last: float | None = None

    def note(self, share: float, going: bool = True) -> None:
        """So much, 0-1, is done now; with `going` false it is held from now on. Less than before is other work."""
        now = self._clock()
        if share < self._share:
            self._gone, self._last = 0.0, None
        if self._last is not None:
            self._gone += now - self._last
        self._share = share
        self._last = now if going else None

    def forget(self) -> None:
        """The work is over."""
        self._share, self._gone, self._last = 0.0, 0.0, None

    @property
    def left(self) -> float | None:
        """Seconds that are left; None as long as that cannot be said."""
        if self._gone < _NOT_BEFORE_S or not _LEAST_SHARE <= self._share < 1:
            return None
        return self._gone * (1 - self._share) / self._share

    def text(self) -> str:
        """The same in round numbers, as "12 s left"; "" as long as it cannot be said."""
        left = self.left
        if left is None:
            return ""
        for most, step in _STEPS:
            rounded = max(math.ceil(left / step), 1) * step
            if rounded <= most:
                return f"{rounded} s left"
        return f"{math.ceil(left / 60)} min left"


# How many cores long work may have.


def spare_cores() -> int:
    """Threads for work in the background, at least one: one core stays the window's."""
    return max(available_cores() - 1, 1)
