"""How a frame that is open stands at a moment, taken in no time, to be stored by another thread."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gui.project.tiles import Tiles
from gui.state.session import Session
from ilf.project import FrameState, Guess, KeptRun, Looked


class SessionCapture:
    """Takes the state of one session, again and again: only what has changed since the last time costs anything.

    Nobody else may ask the session where its arrays have changed.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._labels = Tiles[np.int32]()
        self._drawn = Tiles[np.bool_]()

    def take(self) -> Callable[[], FrameState]:
        """The state as it is now, to be put together in any thread."""
        session = self._session
        dirty = session.take_dirty()
        labels = self._labels.update(session.labels, dirty)
        former = session.notes.drawn
        drawn = None if former is None else self._drawn.update(former, dirty)
        if drawn is None:
            self._drawn = Tiles()
        notes = replace(session.notes, infos=dict(session.notes.infos), own=dict(session.notes.own), drawn=None)
        results = dict(session.valid_results())
        completion = session.completion() if session.guessed else None
        runs = tuple(map(_left_alone, session.kept_runs))
        chains = tuple(tuple(chain) for chain in session.chains.chains)
        state = FrameState(
            session.id,
            session.frame,
            session.labels,
            notes,
            session.common,
            results,
            runs=runs,
            compared=tuple(kept.number for kept in session.compared),
            next_number=session.next_run,
            dense=session.dense,
            own_parameters=session.own_parameters,
            note=session.note,
            to_check=frozenset(session.to_check),
            selected=tuple(session.selected),
            looked=Looked(session.line, session.region, chains, session.chains.reference),
            view=dict(session.view),
        )

        def whole() -> FrameState:
            return replace(
                state,
                labels=labels(),
                notes=replace(notes, drawn=None if drawn is None else drawn()),
                guess=None if completion is None else Guess.of(completion),
            )

        return whole


def _left_alone(kept: KeptRun) -> KeptRun:
    """A copy that does not follow what becomes of the run, nor holds its depth."""
    one = copy.copy(kept)
    one._composed = one._held = None
    return one
