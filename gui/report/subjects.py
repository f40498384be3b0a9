"""Frames of the window as subjects of a report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gui.project.store import WorkStore
from gui.state.entries import Entry
from gui.state.session import Session
from ilf.errors import IlfError
from ilf.outcomes import compose
from ilf.parameters import Parameters
from ilf.report import Subject, Unreadable


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


def subjects_of(
    entries: Sequence[Entry], store: WorkStore, for_all: Parameters | None
) -> Iterator[Subject | Unreadable]:
    """Frames that have been worked on, open or not; those that are not are read when it is their turn.

    To be called in the GUI's thread, and gone through in any. `for_all`: the parameters of all frames, if there are.
    """
    open_ones = {entry.id: subject_of(entry.session) for entry in entries if entry.session is not None}
    noted = [(entry, entry.note) for entry in entries]
    return (open_ones.get(entry.id) or _stored(entry, note, store, for_all) for entry, note in noted)


def _stored(entry: Entry, note: str, store: WorkStore, for_all: Parameters | None) -> Subject | Unreadable:
    try:
        decoded = store.read(entry.id, entry.source)
    except IlfError as error:
        return Unreadable(entry.name, str(error))
    return Subject.of_state(decoded.state.as_set(note, for_all), problems=decoded.problems)
