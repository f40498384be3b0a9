"""Reports differences to a recorded run, when it is opened and when it has been run again."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject

from ilf.data.results import Completion
from ilf.run.run import Run

from ...state.results import same_guide, same_mask
from ...state.session import Session
from ...widgets.notices import Notes


class ReplayPresenter(QObject):
    """Reports the comparison of a run with its record."""

    def __init__(self, notes: Notes) -> None:
        super().__init__(notes)
        self._notes = notes

    def show_differences(self, session: Session) -> None:
        """Report which input, network, version or output of a session opened from a record differs, if any."""
        if session.record_replay is not None:
            self._notes.warn(f"{session.name}: differences to the run record", session.record_replay.differences)

    def show_verdict(self, session: Session) -> None:
        """If the run that has ended is the recorded one, report whether its result equals the record."""
        completion = session.completion()
        if (
            session.record_replay is None
            or completion is None
            or not _is_recorded_run(session, session.record_replay.run, completion)
        ):
            return
        verdict = session.record_replay.verdict(completion)
        if verdict:
            self._notes.warn(f"{session.name}: the result differs from the run record", verdict)
        else:
            self._notes.show_message(f"{session.name}: the result equals the run record.")


def _is_recorded_run(session: Session, recorded: Run, completion: Completion) -> bool:
    """Whether the completion is of the recorded run: the same blocks with drawn borders, invalid mask, guide and
    parameters."""
    if session.extrapolated != recorded.extrapolate or not np.array_equal(session.labels, recorded.blocks):
        return False
    drawn, invalid_mask = session.notes.drawn, session.frame.invalid_mask
    if not (same_mask(drawn, recorded.drawn) and same_mask(invalid_mask, recorded.frame.invalid_mask)):
        return False
    if not same_guide(session.frame.guide, recorded.frame.guide):
        return False
    return set(completion.results) == (recorded.only or frozenset()) and all(
        result.parameters == recorded.parameters_of(label) for label, result in completion.results.items()
    )
