"""A frame that is open again as it was stored."""

from __future__ import annotations

from dataclasses import replace

from gui.state.chains import Chains
from gui.state.session import Session
from ilf.project import FrameState


def restore(state: FrameState, origin: object, key: str) -> Session:
    """A session of a stored frame, to be added to the workspace. Its history is empty, and nothing of it is unsaved.

    Parameters
    ----------
    state : FrameState
    origin : object
        What it is opened from.
    key : str
        The path of that.
    """
    session = Session(state.frame, origin, key)
    session.id, session.note = state.id, state.note
    notes = state.notes
    session.take_notes(
        replace(
            notes,
            infos=dict(notes.infos),
            own=dict(notes.own),
            drawn=None if notes.drawn is None else notes.drawn.copy(),
        )
    )
    session.set_labels(state.labels)
    session.take_common(state.common)
    session.own_parameters, session.dense = state.own_parameters, state.dense
    session.bring_back(list(state.results.values()), state.guess)
    session.kept_runs = list(state.runs)
    session.compared = [kept for kept in state.runs if kept.number in state.compared]
    for kept in session.compared:
        kept.hold(True)
    session.next_run = state.next_number
    there = session.counts().keys()
    session.to_check = set(state.to_check & there)
    session.selected = [label for label in state.selected if label in there]
    looked = state.looked
    session.line, session.region = looked.line, looked.region
    session.chains = Chains([list(chain) for chain in looked.chains], reference=looked.reference)
    session.view = dict(state.view)
    session.note_saved(session.stamp)
    return session
