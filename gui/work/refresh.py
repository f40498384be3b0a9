"""Bringing the widgets up to date: what is stale is drawn once per turn of the event loop, however often it changed."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QObject, Qt, QTimer, Signal, SignalInstance

_INTERVAL_S = 0.15
"""Least time between drawings of what can wait."""

_COSTS = 6.0
"""The same, in times that drawing takes, so that the window has most of its time for the user."""


class Refresh(QObject):
    """The window's parts by name, each with what draws it.

    Signals mark parts as stale. Those that matter to whoever has just done something are drawn at the next turn of
    the event loop; those that change several times a second of themselves, as in a run, can wait. In a turn every part
    is drawn at most once, in the order in which they were added.
    """

    _wanted = Signal()

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._draw: dict[str, Callable[[], None]] = {}
        self._stale: set[str] = set()
        self._patient: set[str] = set()
        self._not_before = 0.0
        self._stopped = False
        self._coming = False
        # not a timer of no time: what the user does next would come before it
        self._wanted.connect(self._turn, Qt.ConnectionType.QueuedConnection)
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(self._turn)

    def add(
        self,
        part: str,
        draw: Callable[[], None],
        on: tuple[SignalInstance, ...],
        later_on: tuple[SignalInstance, ...] = (),
    ) -> None:
        """Add a part, which these signals make stale: at once, or in a while."""
        self._draw[part] = draw
        for signal in on:
            signal.connect(lambda *_: self.mark(part))
        for signal in later_on:
            signal.connect(lambda *_: self.mark_later(part))

    def mark(self, *parts: str) -> None:
        """These parts are stale; they are drawn at the next turn of the event loop."""
        self._stale.update(parts)
        self._schedule()

    def mark_later(self, *parts: str) -> None:
        """These parts are stale; they are drawn when the window has had time for other things."""
        self._patient.update(parts)
        self._schedule()

    def now(self) -> None:
        """Draw at once what would be drawn at the next turn."""
        if self._stale:
            self._turn()

    def draw_all(self) -> None:
        """Draw every part, as at the start."""
        self.mark(*self._draw)
        self.now()

    def stop(self) -> None:
        """Draw nothing any more."""
        self._stopped = True
        self._later.stop()

    def _schedule(self) -> None:
        if self._stopped:
            return
        if self._stale and not self._coming:
            self._coming = True
            self._wanted.emit()
        elif self._patient and not self._stale and not self._later.isActive():
            self._later.start(max(round(1000 * (self._not_before - time.perf_counter())), 0))

    def _turn(self) -> None:
        self._coming = False
        if self._stopped:
            return
        begun = time.perf_counter()
        waited = bool(self._patient) and begun >= self._not_before
        if waited:
            self._stale |= self._patient
            self._patient.clear()
        try:
            for part, draw in self._draw.items():
                if part in self._stale:
                    self._stale.discard(part)
                    self._patient.discard(part)
                    draw()
        finally:
            if waited:
                ended = time.perf_counter()
                self._not_before = ended + max(_INTERVAL_S, _COSTS * (ended - begun))
            self._schedule()
