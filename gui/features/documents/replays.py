"""Says what is not as it was when a run was recorded: when it is opened, and when it has been run again."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject

from ilf.data.results import Completion
from ilf.run.run import Run

from ...state.results import same_guide, same_mask
from ...state.session import Session
from ...widgets.notices import Notes


class ReplayPresenter(QObject):
    """Brings what a record says of its run to the user."""

    def __init__(self, notes: Notes) -> None:
        super().__init__(notes)
        self._notes = notes

    def show_differences(self, session: Session) -> None:
        """A session has been opened from a record: say which input, network, version or output differs, if any."""
        if session.again is not None:
            self._notes.warn(f"{session.name}: not all is as it was recorded", session.again.differences)

    def show_verdict(self, session: Session) -> None:
        """A run has ended: if it is the recorded one, say whether it came out as recorded."""
        completion = session.completion()
        if session.again is None or completion is None or not _is_again(session, session.again.run, completion):
            return
        verdict = session.again.verdict(completion)
        if verdict:
            self._notes.warn(f"{session.name}: the run did not come out as recorded", verdict)
        else:
            self._notes.tell(f"{session.name}: the run came out as recorded.")


def _is_again(session: Session, recorded: Run, completion: Completion) -> bool:
    """Whether the completion is of the very run that was recorded: its blocks with their drawn borders, the depth that
    was distrusted then, its guide and its parameters."""
    if session.guessed != recorded.dense or not np.array_equal(session.labels, recorded.blocks):
        return False
    drawn, distrusted = session.notes.drawn, session.frame.distrusted
    if not (same_mask(drawn, recorded.drawn) and same_mask(distrusted, recorded.frame.distrusted)):
        return False
    if not same_guide(session.frame.guide, recorded.frame.guide):
        return False
    return set(completion.results) == (recorded.only or frozenset()) and all(
        result.parameters == recorded.parameters_of(label) for label, result in completion.results.items()
    )
