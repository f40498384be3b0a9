"""Carries blocks from frame to frame, off the GUI's thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.project.propagation import Carried, carry
from ilf.sources.frame_source import FrameSource

from ...state.entries import Entry
from ...state.session import Session
from ...state.workspace import Workspace
from ...widgets.notices import error_text
from ...work.jobs import Worker
from ...work.loading import FrameLoader, StoredFrames, restore

# Frames as what carrying works on: states, which may be read in any thread.


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


_WORKED_ON = Stage.EDITED, Stage.RUN, Stage.FAILED


class Arrival(NamedTuple):
    """What came of carrying blocks to one frame: how, how many blocks it has, and how many of them are new, need a
    look, or are gone."""

    name: str
    how: str
    blocks: int
    new: int
    to_check: int
    gone: int
    notes: tuple[str, ...]


@dataclass(eq=False)
class Journey:
    """Blocks on their way through frames of the list.

    Attributes
    ----------
    source : Entry
        Whose blocks are carried first.
    how : str
        "auto", "copied" or "flow".
    replaces : bool
        Whether frames that have been worked on get other blocks, too; those that do not, keep theirs, which are carried
        on from there.
    shows : bool
        Whether frames are shown as soon as they are read.
    total : int
        How many frames there are after the source.
    done : list of Arrival
        Frames that have got blocks.
    kept : list of str
        Names of frames that have kept theirs.
    problems : list of str
        Frames that could not be read, or carried to, a sentence each.
    """

    source: Entry
    how: str
    replaces: bool
    shows: bool
    total: int
    done: list[Arrival] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    stopped: bool = False

    @property
    def over(self) -> int:
        """How many frames are done with."""
        return len(self.done) + len(self.kept) + len(self.problems)


class Carrier(QObject):
    """One journey at a time: every frame is read and opened, and gets the blocks of the one before as an undoable step.

    Signals
    -------
    changed()
        A journey has begun, has come to another frame, or has ended.
    ended(object)
        The `Journey` that is over.
    """

    changed = Signal()
    ended = Signal(object)

    def __init__(self, workspace: Workspace, loader: FrameLoader, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._loader = loader
        self.journey: Journey | None = None
        """The one under way."""
        self._waiting: deque[Entry] = deque()
        self._present: Entry | None = None
        self._before: FrameState | None = None
        """The frame whose blocks are carried next."""
        self._read: Reading | None = None
        """The frame that blocks are carried to, as it was."""
        self._worker = Worker(self)
        self._worker.progressed.connect(self._take_read)
        self._worker.finished.connect(self._take)
        self._worker.failed.connect(self._fail)
        self._worker.cancelled.connect(self._end)

    @property
    def present(self) -> Entry | None:
        """The frame that blocks are carried to; None for none."""
        return None if self.journey is None else self._present

    def start(
        self, source: Entry, targets: Sequence[Entry], how: str, replaces: bool = False, shows: bool = False
    ) -> None:
        """Carry blocks from a frame to others, from one to the next; nothing if a journey is under way."""
        if self.journey is None and targets:
            self.journey = Journey(source, how, replaces, shows, len(targets))
            self._waiting = deque((source, *targets))
            self._before = None
            self._next()

    def stop(self) -> None:
        """Carry no further; `ended` follows."""
        if self.journey is not None:
            self.journey.stopped = True
            self._waiting.clear()
            self._worker.cancel()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        self._waiting.clear()
        return self._worker.shutdown()

    def _next(self) -> None:
        journey = self.journey
        while journey is not None and self._waiting and not self._is_listed(self._waiting[0]):
            self._waiting.popleft()
            journey.total -= 1
        if journey is None or not self._waiting:
            self._end()
            return
        self._present = entry = self._waiting.popleft()
        self._read = None
        before, how = self._before, journey.how
        read = reading(entry, self._loader.stored)
        stays = before is None or (entry is not journey.source and self._keeps(entry, journey))

        def job() -> Generator[Reading, None, Carried | FrameState]:
            found = read()
            yield found
            return found.state if stays or before is None else carry(before, found.state, how)

        self._worker.start(job)
        self.changed.emit()

    def _is_listed(self, entry: Entry) -> bool:
        """Whether a frame is still in the list."""
        return self._workspace.entries.of(entry.id) is entry

    @staticmethod
    def _keeps(entry: Entry, journey: Journey) -> bool:
        summary = entry.summary
        return not journey.replaces and summary.blocks > 0 and summary.stage in _WORKED_ON

    def _take_read(self, found: list[Reading]) -> None:
        """A frame has been read; it is shown while blocks are on their way to it."""
        entry, self._read, journey = self._present, found[-1], self.journey
        shows = journey is not None and journey.shows and entry is not journey.source
        if shows and entry is not None and self._is_listed(entry):
            self._workspace.show_session(self._open(entry, self._read))

    def _take(self, outcome: Carried | FrameState) -> None:
        journey, entry = self.journey, self._present
        if journey is None or entry is None:
            return
        if not self._is_listed(entry):  # it has been taken out meanwhile
            journey.total -= 1
            if entry is journey.source:
                self._waiting.clear()
        elif isinstance(outcome, Carried) and self._read is not None:
            session, source = self._open(entry, self._read), outcome.state.notes.carried_from
            self._workspace.take_carried(session, outcome.state, f"Carry blocks from {source}")
            journey.done.append(_arrival(session, outcome))
            self._before = outcome.state
        elif isinstance(outcome, FrameState) and outcome.labels.any():
            if entry is not journey.source:
                journey.kept.append(entry.name)
            self._before = outcome
        else:
            journey.problems.append(f"{entry.name} has no blocks to carry: extract or draw some first.")
            self._waiting.clear()
        self._next()

    def _open(self, entry: Entry, found: Reading) -> Session:
        """The session of a frame, which is opened if it is not."""
        if entry.session is None:
            session = session_of(entry, found.state)
            self._workspace.add_session(session, restored=entry.has_state, show=False)
            if found.problems:
                self._loader.incomplete.emit(session, found.problems)
            return session
        return entry.session

    def _fail(self, error: Exception) -> None:
        journey, entry = self.journey, self._present
        if journey is not None and entry is not None:
            journey.problems.append(f"{entry.name}: {error_text(error)}")
            if self._read is None:
                self._workspace.note_problem(entry, error_text(error))
            if self._before is None:
                self._waiting.clear()
        self._next()

    def _end(self) -> None:
        journey, self.journey = self.journey, None
        self._present = self._before = self._read = None
        self.changed.emit()
        if journey is not None:
            self.ended.emit(journey)


def _arrival(session: Session, carried: Carried) -> Arrival:
    followed, marked = carried.followed, len(carried.state.to_check)
    counts = len(session.counts()), len(followed.new), marked, len(followed.gone)
    return Arrival(session.name, followed.how, *counts, followed.notes)
