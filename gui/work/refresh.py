"""Deferred refresh of widgets: a stale widget is redrawn once per event loop turn, however often it changed."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, SignalInstance

from ..state.parts import EVERY_PART, NO_PART, Part
from ..state.workspace import Workspace

_INTERVAL_S = 0.15
"""Minimum time [s] between redraws of deferrable parts."""

_COST_FACTOR = 6.0
"""The same as a multiple of the redraw's duration, so that most time is left for user input."""


class Refresh(QObject):
    """What the window draws, by name, each with its draw function.

    Changed parts of the state and signals mark it as stale. What responds to user input is drawn at the next turn of
    the event loop; what changes several times a second by itself, as in a run, can wait. In a turn everything is drawn
    at most once, in the order in which it was added.
    """

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._parts: dict[str, tuple[Part, Part]] = {}
        self._changed: dict[str, Part] = {}
        """What has changed since something was drawn last."""
        self._names: list[str] = []
        self._draw: dict[str, Callable[[], None]] = {}
        self._seen: dict[str, Callable[[], bool]] = {}
        self._stale: set[str] = set()
        self._deferred: set[str] = set()
        self._not_before = 0.0
        self._stopped = False
        self._later = QTimer(self, singleShot=True)
        self._later.timeout.connect(workspace.tell)
        workspace.changed.connect(self._turn)

    def add(
        self,
        name: str,
        draw: Callable[[], None],
        on: Part,
        deferred_on: Part = NO_PART,
        also: tuple[SignalInstance, ...] = (),
        when: Callable[[], bool] = lambda: True,
    ) -> None:
        """Add something to be drawn, for the first time at the next turn.

        Parameters
        ----------
        name : str
        draw : callable
        on, deferred_on : Part
            Parts of the state that mark it for the next turn, and for later.
        also : tuple of signals
            Of widgets, that mark it for the next turn.
        when : callable
            Returns whether it is seen; it is not drawn otherwise, and who shows it marks it.
        """
        self._names.append(name)
        self._draw[name] = draw
        self._seen[name] = when
        self._changed[name] = EVERY_PART
        self._parts[name] = on, deferred_on
        for signal in also:
            signal.connect(lambda *_: self.mark(name))
        self.mark(name)

    def defer(self, name: str, parts: Part) -> None:
        """Set the parts of the state that mark something for later, as long as what it shows depends on them."""
        self._parts[name] = self._parts[name][0], parts

    def changed(self, name: str) -> Part:
        """Return what has changed since this was asked last, for one that draws only that."""
        changed, self._changed[name] = self._changed[name], NO_PART
        return changed

    def mark(self, *parts: str) -> None:
        """Mark parts as stale, to be drawn at the next turn of the event loop; KeyError for what was not added, which
        would never be drawn."""
        if unknown := set(parts) - self._draw.keys():
            raise KeyError(f"nothing draws {', '.join(sorted(unknown))}")
        self._stale.update(parts)
        self._workspace.wake()

    def now(self) -> None:
        """Draw now what would be drawn at the next turn."""
        self._workspace.tell()

    def stop(self) -> None:
        """Stop drawing permanently."""
        self._stopped = True
        self._later.stop()

    def _turn(self, parts: Part) -> None:
        """Draw what changed parts and marks concern; what can wait is drawn later, or with the rest if it is due."""
        if self._stopped:
            return
        self._changed = {name: changed | parts for name, changed in self._changed.items()}
        self._stale.update(name for name, (on, _) in self._parts.items() if on & parts)
        self._deferred.update(name for name, (_, later) in self._parts.items() if later & parts)
        begun = time.perf_counter()
        due = bool(self._deferred) and begun >= self._not_before and (bool(self._stale) or not parts)
        if due:
            self._stale |= self._deferred
            self._deferred.clear()
        try:
            for name in self._names:  # also those that are added meanwhile, by what is shown for the first time
                if name in self._stale:
                    self._stale.discard(name)
                    self._deferred.discard(name)
                    if self._seen[name]():
                        self._draw[name]()
        finally:
            if due:
                ended = time.perf_counter()
                self._not_before = ended + max(_INTERVAL_S, _COST_FACTOR * (ended - begun))
            if self._stale:
                self._workspace.wake()
            elif self._deferred and not self._later.isActive():
                self._later.start(max(round(1000 * (self._not_before - time.perf_counter())), 0))
