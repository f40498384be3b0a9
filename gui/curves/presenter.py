"""Brings the records of a block to the curves while it runs, and afterwards."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject

from gui.curves.curves_panel import EMPTY_TEXT, CurvesPanel
from gui.state.block_notes import BlockInfo
from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.filter.convergence import IterationRecord
from ilf.parameters import Parameters


class CurvesPresenter(QObject):
    """The curves of the chosen block; while that has none yet, of the one that runs, or else of the first that has."""

    def __init__(self, workspace: Workspace, curves: CurvesPanel) -> None:
        super().__init__(curves)
        self._workspace = workspace
        self._curves = curves
        self._shown: tuple[Session, BlockInfo, float | None] | None = None
        self._records: Sequence[IterationRecord] = ()

    def show(self) -> None:
        """Draw the curves: those that are shown already get what has come since, others start anew.

        Nothing is drawn while nobody can see it.
        """
        if not self._curves.isVisible():
            return
        session = self._workspace.session if self._workspace.has_session else None
        label = self._label(session) if session is not None else 0
        if session is None or label == 0:
            if self._shown is not None:
                self._curves.clear()
            self._shown, self._records = None, ()
            return
        self._curves.set_hint(_hint(session, label))
        info, records = session.info(label), session.records_of(label)
        criterion = _criterion(self._parameters(session, label))
        if self._shown != (session, info, criterion):
            self._curves.set_block(label, info.name, info.colour)
            self._curves.set_s_criteria(criterion)
        elif records is self._records:
            self._curves.append_records(records[len(self._curves.records) :])
            return
        self._shown, self._records = (session, info, criterion), records
        self._curves.set_records(records)

    def _label(self, session: Session) -> int:
        chosen, running = self._workspace.chosen, session.results.running
        if chosen and session.records_of(chosen):
            return chosen
        if running:
            return running[-1]
        return chosen or next((label for label, result in session.valid_results().items() if result.history), 0)

    def _parameters(self, session: Session, label: int) -> Parameters:
        """What the curve was, or would be, run with."""
        result = session.valid_results().get(label)
        if result is not None and result.history and label not in session.results.live:
            return result.parameters
        return session.parameters_of(label, self._workspace.parameters)


def _hint(session: Session, label: int) -> str:
    """Why a block has no curves."""
    result = session.valid_results().get(label)
    if result is None or result.history:
        return EMPTY_TEXT
    return result.outcome.message or EMPTY_TEXT


def _criterion(parameters: Parameters) -> float | None:
    """The stop criterion [m]; None where it has no part in a run, as in the linear schedule."""
    used = parameters.filter == "edge-aware" or parameters.schedule == "staged"
    return parameters.s_criteria if used else None
