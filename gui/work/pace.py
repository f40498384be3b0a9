"""How long what is under way will still take."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

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
