"""Brings the records of blocks and of compared runs to the curves while they run, and afterwards."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QObject

from gui.curves.curve import Curve
from gui.curves.curves_panel import EMPTY_TEXT, CurvesPanel
from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.frame import RGBDFrame
from ilf.number_words import length_text
from ilf.outcomes import BlockResult
from ilf.parameters import Parameters

MOST_CURVES = 8


class CurvesPresenter(QObject):
    """The curves of the chosen blocks; while they have none yet, of the block that runs, and where no block is chosen
    of the one that took the most iterations. With them, the same blocks in the runs that are compared."""

    def __init__(self, workspace: Workspace, panel: CurvesPanel) -> None:
        super().__init__(panel)
        self._workspace = workspace
        self._panel = panel

    def show(self) -> None:
        """Draw the curves: those that are shown already get what has come since, others start anew.

        Nothing is drawn while nobody can see it.
        """
        if not self._panel.isVisible():
            return
        session = self._workspace.session if self._workspace.has_session else None
        labels = [] if session is None else _shown(session)
        if session is None or not labels:
            self._panel.set_hint()
            self._panel.show_curves([])
            return
        self._panel.set_hint(_hint(session, labels[0]))
        curves = [_of_block(session, label) for label in labels]
        self._panel.show_curves([*curves, *_of_compared(session, labels)][:MOST_CURVES])


def _shown(session: Session) -> list[int]:
    """The blocks whose curves are shown, or if there are none, the block that is to be said why of."""
    with_records = [label for label in session.selected if session.records_of(label)]
    if with_records:
        return with_records
    if session.results.running:
        return session.results.running[-1:]
    if session.selected:
        return session.selected[:1]
    lengths = {label: len(result.history) for label, result in session.valid_results().items()}
    longest = max(lengths, key=lambda label: lengths[label], default=0)
    return [longest] if lengths.get(longest) else []


def _of_block(session: Session, label: int) -> Curve:
    info = session.info(label)
    parameters = session.parameters_of(label, session.common)
    metres = _criterion(parameters)
    remarks = ["own"] if "s_criteria" in session.notes.own.get(label, {}) else []
    result = session.valid_results().get(label)
    if result is not None and result.history and label not in session.results.live:
        then = _criterion(result.parameters)
        if then is not None and then != metres:
            remarks.append(f"was run with {length_text(then)}")
    return Curve(
        info.name or f"Block {label}",
        info.colour,
        session.records_of(label),
        s_criteria=metres,
        remark=", ".join(remarks),
        corrected=math.nan if result is None else _corrected_error(result, session.frame),
    )


def _of_compared(session: Session, labels: Sequence[int]) -> list[Curve]:
    """The same blocks in the runs that are compared, run by run."""
    curves = []
    for kept in session.compared:
        for label in labels:
            result = kept.results.get(label)
            if result is not None and result.history:
                name = kept.name if len(labels) == 1 else f"{kept.name}: {session.info(label).name}"
                corrected = _corrected_error(result, kept.run.frame)
                curves.append(Curve(name, kept.colour, result.history, dashed=True, corrected=corrected))
    return curves


def _corrected_error(result: BlockResult, frame: RGBDFrame) -> float:
    """What `IterationRecord.error` says of iterations, of the depth after the learned correction; NaN without one."""
    if result.correction is None or frame.truth is None:
        return math.nan
    box, mask = result.block.box, result.block.mask
    off = (result.depth - frame.truth[box][mask])[~frame.known[box][mask]].astype(np.float64)
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off * off))) if off.size else math.nan


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
