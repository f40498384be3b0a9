"""Frames of the window as subjects of a report."""

from __future__ import annotations

from gui.state.entries import Entry
from gui.state.session import Session
from ilf.outcomes import compose
from ilf.project import Stage
from ilf.report import Subject


def subject_of(session: Session) -> Subject:
    """A frame that is open, as it is now; what becomes of it afterwards does not show."""
    completion = session.completion() or compose(session.frame, {})
    infos = {label: session.info(label) for label in session.counts()}
    return Subject(
        session.run(session.common, dense=session.guessed),
        completion,
        {label: info.name for label, info in infos.items()},
        {label: info.colour for label, info in infos.items()},
        session.note,
        tuple(session.kept_runs),
    )


def is_worked_on(entry: Entry) -> bool:
    """Whether somebody has done anything with a frame beyond opening it."""
    summary = entry.summary
    return bool(summary.note) or summary.stage not in (Stage.UNTOUCHED, Stage.EXTRACTED)
