"""Frames as what carrying works on: states, which may be read in any thread."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gui.frames.loader import StoredFrames
from gui.project.restore import restore
from gui.state.entries import Entry
from gui.state.session import Session
from ilf.io.frame_source import FrameSource
from ilf.project import FrameState


class Reading(NamedTuple):
    """A frame as it was read, and what of it could not be read, a sentence each."""

    state: FrameState
    problems: tuple[str, ...] = ()


def state_of(session: Session) -> FrameState:
    """A frame that is open, without its results."""
    notes = session.notes
    known = replace(
        notes,
        infos=dict(notes.infos),
        own=dict(notes.own),
        drawn=None if notes.drawn is None else notes.drawn.copy(),
    )
    return FrameState(
        session.id,
        session.frame,
        session.labels.copy(),
        known,
        session.common,
        dense=session.dense,
        own_parameters=session.own_parameters,
        to_check=frozenset(session.to_check),
        selected=tuple(session.selected),
    )


def reading(entry: Entry, stored: StoredFrames | None) -> Callable[[], Reading]:
    """What gives the state of a frame of the list, in any thread: as it is now if it is open, else as it was stored,
    else as its files have it, without blocks."""
    if entry.session is not None:
        read = Reading(state_of(entry.session))
        return lambda: read
    id, source = entry.id, entry.source
    if entry.has_state and stored is not None and stored.has(id):

        def decoded() -> Reading:
            found = stored.read(id, source)
            return Reading(found.state, found.problems)

        return decoded

    def load() -> Reading:
        frame = _origin(entry).load()
        return Reading(FrameState(id, frame, np.zeros(frame.shape, np.int32)))

    return load


def session_of(entry: Entry, state: FrameState) -> Session:
    """A session of a frame that is not open, whose state has been read."""
    if entry.has_state:
        return restore(state, entry.source or Path(entry.key), entry.key)
    session = Session(state.frame, _origin(entry), entry.key)
    session.id = entry.id  # others may be of the same files
    return session


def _origin(entry: Entry) -> FrameSource:
    return entry.source or FrameSource(entry.key)
