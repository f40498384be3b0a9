"""A generator that is driven in a thread of its own, at the pace that somebody orders."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Generator
from enum import Enum
from typing import Any

from ilf.stopping import heed

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
