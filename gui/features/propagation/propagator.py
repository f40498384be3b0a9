"""Propagates blocks from frame to frame, in a worker thread."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf.data.blocks import Blocks
from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.project.propagation import Propagated, propagate_state
from ilf.project.recorded_frames import measured_frame
from ilf.project.state_codec import Decoded
from ilf.sources.frame_ref import FrameRef

from ...project.loading import FrameLoader, state_reader
from ...project.store import WorkStore
from ...state.document import Document
from ...state.entries import Entry
from ...state.workspace import Workspace
from ...widgets.notices import error_text
from ...work.latest_request import LatestRequest

# Frames as input of the propagation: states, which may be read in any thread.


def read_without_blocks(entry: Entry, store: WorkStore) -> Decoded:
    """Read the files of a frame of the list that has no state."""
    frame = measured_frame(entry.source or FrameRef(entry.key), store.places)
    return Decoded(FrameState(entry.id, frame, Blocks(np.zeros(frame.shape, np.int32))))


_WORKED_ON = Stage.EDITED, Stage.RUN, Stage.FAILED


class PropagatedFrame(NamedTuple):
    """Result of the propagation to one frame: method, number of blocks, and how many of them are new, need a check, or
    are gone."""

    name: str
    how: str
    blocks: int
    new: int
    to_check: int
    gone: int
    notes: tuple[str, ...]


@dataclass(eq=False)
class PropagationRun:
    """A propagation of blocks through frames of the list.

    Attributes
    ----------
    source : Entry
        The frame with the original blocks.
    how : str
        "auto", "copied" or "flow".
    replaces : bool
        Whether blocks of frames that have been worked on are replaced; otherwise these frames keep their blocks, which
        are propagated further.
    shows : bool
        Whether each frame is shown as soon as it is read.
    waiting : deque of Entry
        Frames that follow; the source is the first.
    total : int
        Number of frames after the source.
    present : Entry
        The target frame; the source while that is read.
    before : FrameState or None
        State of the frame whose blocks are propagated next; None before the source was read.
    done : list of PropagatedFrame
        Frames that have received blocks.
    kept : list of str
        Names of frames that have kept their blocks.
    problems : list of str
        A sentence for each frame that could not be read or propagated to.
    """

    source: Entry
    how: str
    replaces: bool
    shows: bool
    waiting: deque[Entry]
    total: int
    present: Entry
    before: FrameState | None = None
    done: list[PropagatedFrame] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    stopped: bool = False

    @property
    def processed(self) -> int:
        """Number of processed frames."""
        return len(self.done) + len(self.kept) + len(self.problems)


class Propagator(QObject):
    """Runs one propagation at a time: each frame is opened and gets the blocks of the previous one as an undoable step.

    Signals
    -------
    changed()
        A propagation has started, has reached another frame, or has ended.
    ended(object)
        The `PropagationRun` that has ended.
    """

    changed = Signal()
    ended = Signal(object)

    def __init__(self, workspace: Workspace, loader: FrameLoader, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._loader = loader
        self._requests = LatestRequest(self)
        self.propagation_run: PropagationRun | None = None
        """The propagation in progress; None for none."""

    def start(
        self, source: Entry, targets: Sequence[Entry], how: str, replaces: bool = False, shows: bool = False
    ) -> None:
        """Propagate blocks from a frame through others; do nothing if a propagation is in progress."""
        if self.propagation_run is None and targets:
            waiting = deque((source, *targets))
            self.propagation_run = PropagationRun(source, how, replaces, shows, waiting, len(targets), source)
            self._next(self.propagation_run)

    def stop(self) -> None:
        """Stop the propagation."""
        run = self.propagation_run
        if run is not None:
            run.stopped = True
            self._requests.cancel()
            self._end(run)

    def _next(self, run: PropagationRun) -> None:
        """Read the next frame that is still listed."""
        while run.waiting and run.waiting[0] not in self._workspace.entries:
            run.waiting.popleft()
            run.total -= 1
        if not run.waiting:
            self._end(run)
            return
        entry = run.present = run.waiting.popleft()
        store = self._loader.store
        read = state_reader(entry, store) or partial(read_without_blocks, entry, store)
        self._requests.ask(read, partial(self._take_read, run), partial(self._fail, run, None))
        self.changed.emit()

    def _take_read(self, run: PropagationRun, read: Decoded) -> None:
        """Propagate the blocks of the frame before to one that has been read, and show it meanwhile."""
        entry, before = run.present, run.before
        if run.shows and entry is not run.source and entry in self._workspace.entries:
            self._workspace.show(self._open(entry, read))
        if before is None or (entry is not run.source and _keeps(entry, run)):
            self._take(run, read, read.state)
        else:
            found = partial(propagate_state, before, read.state, run.how)
            self._requests.ask(found, partial(self._take, run, read), partial(self._fail, run, read))

    def _take(self, run: PropagationRun, read: Decoded, outcome: Propagated | FrameState) -> None:
        entry = run.present
        if entry not in self._workspace.entries:  # it has been removed from the list meanwhile
            run.total -= 1
            if entry is run.source:
                run.waiting.clear()
        elif isinstance(outcome, Propagated):
            document, source = self._open(entry, read), outcome.state.blocks.propagated_from
            self._workspace.take_propagated(document, outcome.state, f"Propagate blocks from {source}")
            run.done.append(_arrival(document, outcome))
            run.before = outcome.state
        elif outcome.blocks.labels.any():
            if entry is not run.source:
                run.kept.append(entry.name)
            run.before = outcome
        else:
            run.problems.append(f"{entry.name} has no blocks to propagate: extract or draw some first.")
            run.waiting.clear()
        self._next(run)

    def _open(self, entry: Entry, found: Decoded) -> Document:
        """Return the document of a frame, which is opened if necessary."""
        return entry.document or self._loader.open_state(entry, found, show=False)

    def _fail(self, run: PropagationRun, read: Decoded | None, error: Exception) -> None:
        run.problems.append(f"{run.present.name}: {error_text(error)}")
        if read is None:
            self._workspace.note_problem(run.present, error_text(error))
        if run.before is None:
            run.waiting.clear()
        self._next(run)

    def _end(self, run: PropagationRun) -> None:
        self.propagation_run = None
        self.changed.emit()
        self.ended.emit(run)


def _keeps(entry: Entry, run: PropagationRun) -> bool:
    summary = entry.summary
    return not run.replaces and summary.blocks > 0 and summary.stage in _WORKED_ON


def _arrival(document: Document, propagated: Propagated) -> PropagatedFrame:
    followed, marked = propagated.followed, len(propagated.state.to_check)
    counts = len(document.counts()), len(followed.new), marked, len(followed.gone)
    return PropagatedFrame(document.name, followed.how, *counts, followed.notes)
