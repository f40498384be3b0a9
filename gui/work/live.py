"""Depth that follows edits: the blocks that an edit has touched are solved again by themselves."""

from __future__ import annotations

from collections.abc import Collection
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction

from gui.state.commands import Change
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.runs import RunController, RunState


class LiveSolver(QObject):
    """Has blocks solved again that were edited since the frame was run, the chosen one first.

    What is touched during a run is solved after it. What undo brings back needs no solving.

    Parameters
    ----------
    live : QAction
        Whether that is wanted.
    """

    def __init__(self, workspace: Workspace, runs: RunController, live: QAction) -> None:
        super().__init__(runs)
        self._workspace = workspace
        self._runs = runs
        self._live = live
        self._touched: WeakKeyDictionary[Session, set[int]] = WeakKeyDictionary()
        """Blocks that are to be solved again, also of frames that are not shown."""
        self._asked: set[int] = set()
        """Those of the present frame that have been asked for since they were touched last."""
        workspace.edited.connect(self._take)
        workspace.distrusted_changed.connect(self._take_all)
        workspace.guide_changed.connect(self._take_all)
        workspace.session_changed.connect(self._turn)
        runs.state_changed.connect(self._go_on)

    def _take(self, change: Change) -> None:
        self._add(change.session, change.blocks)

    def _take_all(self) -> None:
        """Edges, noise and guide are those of all known depth, so that it may have a part in any block."""
        self._add(self._workspace.session, self._workspace.session.counts())

    def _add(self, session: Session, blocks: Collection[int]) -> None:
        if self._live.isChecked() and session.results.kept:
            self._touched.setdefault(session, set()).update(blocks)
            self._asked.difference_update(blocks)
            self._go_on()

    def _turn(self) -> None:
        """What was asked for may be dropped when another frame is shown: it is asked for again when the first is."""
        self._asked.clear()
        self._go_on()

    def _go_on(self) -> None:
        runs, workspace = self._runs, self._workspace
        if not workspace.has_session or runs.state not in (RunState.IDLE, RunState.RESOLVING):
            return
        session, chosen = workspace.session, workspace.chosen
        touched = self._touched.get(session, set())
        if runs.state is RunState.IDLE:  # what was asked for has been solved, or given up
            touched -= self._asked
            self._asked.clear()
        there = touched.intersection(session.counts()) - self._asked
        wanted = [label for label in there if not session.is_up_to_date(label)]
        touched -= there.difference(wanted)  # other values set later are no edit
        wanted.sort(key=lambda label: (label != chosen, label))
        if wanted:
            self._asked.update(wanted)  # before: that the state has changed is heard at once
            if not runs.resolve(wanted, edited=True):
                self._asked.difference_update(wanted)
