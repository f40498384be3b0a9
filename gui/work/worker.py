"""The one worker pattern: a thread drives a generator, a timer brings what it yields to the GUI in batches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from gui.work.job import Command, JobThread, Make

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
