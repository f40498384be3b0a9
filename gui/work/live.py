"""Depth that follows edits: the blocks that an edit has touched are solved again by themselves."""

from __future__ import annotations

from collections.abc import Collection

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
        self._touched: tuple[Session, set[int]] | None = None
        workspace.edited.connect(self._take)
        workspace.distrusted_changed.connect(self._take_all)
        workspace.session_changed.connect(self._go_on)
        runs.state_changed.connect(self._go_on)

    def _take(self, change: Change) -> None:
        self._add(change.session, change.blocks)

    def _take_all(self) -> None:
        """Edges and noise are those of all known depth, so that it may have a part in any block."""
        self._add(self._workspace.session, self._workspace.session.counts())

    def _add(self, session: Session, blocks: Collection[int]) -> None:
        if not (self._live.isChecked() and session.results.kept):
            return
        touched = self._touched[1] if self._touched is not None and self._touched[0] is session else set()
        self._touched = session, touched | set(blocks)
        self._go_on()

    def _go_on(self) -> None:
        if self._touched is None or self._runs.state not in (RunState.IDLE, RunState.RESOLVING):
            return
        session, touched = self._touched
        if not self._workspace.is_present(session):
            return
        self._touched = None
        chosen = self._workspace.chosen
        wanted = sorted(touched.intersection(session.counts()), key=lambda label: (label != chosen, label))
        changed = [label for label in wanted if not session.is_up_to_date(label)]
        if changed and not self._runs.resolve(changed, edited=True):
            self._touched = session, set(changed)
