"""Autosave: writes the window's changes to its journal, in a background thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Generator
from dataclasses import dataclass, field, replace
from weakref import WeakSet

from PySide6.QtCore import QObject, QTimer, Signal

from ilf.errors import IlfError
from ilf.project.encoding import Encoder, frame_part
from ilf.project.frame_state import FrameState
from ilf.project.journal import JournalHeader
from ilf.project.project import Project
from ilf.project.project_json import PROJECT, encode_project
from ilf.project.thumbnail import thumbnail, thumbnail_part

from ..state.session import Session
from ..state.workspace import Workspace
from ..work.jobs import Worker
from .current_project import project_of
from .store import WorkStore

PACE_MS = 300
"""Minimum interval [ms] between snapshots."""
_STROKE_MS = 40
_RETRY_MS = 4000

Then = Callable[[Exception | None], None]


@dataclass
class _Batch:
    """The changes as of one moment."""

    frames: dict[str, FrameState] = field(default_factory=dict)
    project: Project | None = None
    then: list[Then] = field(default_factory=list)
    needs_retry: bool = False
    """Whether earlier changes could not be written to the journal."""

    def __bool__(self) -> bool:
        return bool(self.frames or self.project or self.then or self.needs_retry)


@dataclass(frozen=True)
class _Outcome:
    """The outcome of a batch: errors of encoding and of writing, None for none."""

    encoding: Exception | None
    writing: Exception | None


class Recorder(QObject):
    """Stores changes in the journal, one complete batch at a time, always the newest state.

    Signals
    -------
    kept()
        The journal contains all changes.
    failed(object)
        The exception that prevented it. It is retried automatically.
    """

    kept = Signal()
    failed = Signal(object)

    def __init__(self, workspace: Workspace, store: WorkStore, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.project = ""
        """Path of the project file; "" if there is none yet."""
        self.is_unsaved: Callable[[], bool] = lambda: any(session.unsaved for session in workspace.frames.sessions)
        """Whether there are changes that are not in the project file."""
        self._workspace = workspace
        self.store = store
        self._encoder = Encoder()
        self._touched = WeakSet[Session]()
        self._project_touched = True
        self._frames: frozenset[str] = frozenset()
        """Ids of all frames."""
        self._waiting = _Batch()
        self._current_batch = _Batch()
        self._begun = JournalHeader()
        self._taken = 0.0
        self._automatic = False
        workspace.frames.touched.connect(self._note_touched)
        workspace.frames.project_touched.connect(self.note_project)
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._take)
        self._worker = Worker(self, must_finish=True)
        self._worker.finished.connect(self._finish)
        self._worker.failed.connect(lambda error: self._finish(_Outcome(error, None)))

    def start(self) -> None:
        """Store changes automatically from now on, not only on `flush` and `keep`."""
        self._automatic = True

    def flush(self, then: Then) -> None:
        """Store all changes now. When they are in the journal, or in memory if it cannot be written, call `then` with
        None, or with the exception that prevented storing a frame."""
        self._waiting.then.append(then)
        self._end_stroke()
        self._take()

    def revert(self, frames: Collection[str], then: Callable[[], None]) -> None:
        """Discard the stored states of these frames in favour of those in the project file; then call `then`."""

        def drop(_: Exception | None) -> None:
            for frame in frames:
                self._waiting.frames.pop(frame, None)
            self.store.arrived(frames)
            self.store.revert(frames)
            then()
            self.note_project()  # remove them from the journal, too

        self.flush(drop)

    def keep(self, session: Session) -> None:
        """Store a frame that is about to be closed: its state can be read from now on."""
        self._touched.add(session)
        self._end_stroke()
        self._take()

    def note_project(self) -> None:
        """Note a change of the list of frames, of the shared settings, or of the saved state."""
        self._project_touched = True
        self._schedule()

    def shutdown(self) -> bool:
        """Stop permanently, before the window closes. True if the thread has ended."""
        self._timer.stop()
        return self._worker.shutdown()

    def _note_touched(self, session: Session) -> None:
        self._touched.add(session)
        self._schedule()

    def _schedule(self) -> None:
        if not self._automatic:
            return
        wait = max(round(PACE_MS - (time.monotonic() - self._taken) * 1000), 0)
        if not self._timer.isActive() or self._timer.remainingTime() > wait:
            self._timer.start(wait)

    def _end_stroke(self) -> None:
        if self._workspace.blocks.stroke_in_progress:
            self._workspace.blocks.prepare_change(self._workspace.session)

    def _take(self) -> None:
        """Take a snapshot of all changes; it is stored after the previous one."""
        if self._workspace.blocks.stroke_in_progress:  # a stroke is stored completely or not at all
            self._timer.start(_STROKE_MS)
            return
        self._timer.stop()
        self._taken = time.monotonic()
        batch, there = self._waiting, self._workspace.frames.sessions
        for session in there:
            if session in self._touched:
                if session.id not in batch.frames:
                    self.store.expect(session.id)
                batch.frames[session.id] = session.snapshot()
        self._touched.clear()
        if self._project_touched:
            self._project_touched = False
            batch.project = project_of(self._workspace)
            self._frames = frozenset(frame.id for frame in batch.project.frames)
        self._start()

    def _start(self) -> None:
        if self._worker.busy or not self._waiting:
            return
        self._current_batch, self._waiting = self._waiting, _Batch()
        batch, frames = self._current_batch, self._frames
        unsaved = tuple(entry.id for entry in self._workspace.frames.entries if entry.unsaved)
        note = replace(self._begun, project=self.project, unsaved=self.is_unsaved(), frames=unsaved)

        def job() -> Generator[None, None, _Outcome]:
            yield None
            try:
                return self._store_batch(batch, frames, note)
            finally:
                self.store.arrived(batch.frames.keys())

        self._worker.start(job)

    def _finish(self, outcome: _Outcome) -> None:
        batch, self._current_batch = self._current_batch, _Batch()
        for then in batch.then:
            then(outcome.encoding)
        error = outcome.encoding or outcome.writing
        if self.store.take_lost() or outcome.encoding is not None:
            self._touched.update(self._workspace.frames.sessions)
            self._schedule()
        if error is not None:
            self._waiting.needs_retry = True
            self._timer.start(_RETRY_MS)
            self.failed.emit(error)
            return
        self._start()
        if not self._worker.busy:
            self.kept.emit()

    # in the thread

    def _store_batch(self, batch: _Batch, frames: Collection[str], note: JournalHeader) -> _Outcome:
        store, encoder = self.store, self._encoder
        for decoded in store.take_read():
            encoder.learn(decoded.origins, decoded.names)
        encoding: Exception | None = None
        put: dict[str, bytes] = {}
        refers: dict[str, frozenset[str]] = {}
        for frame_id, state in batch.frames.items():
            try:
                refers[frame_id] = self._encode(state, put)
            except Exception as error:  # any error must affect only this frame
                encoding = error
        if batch.project is not None:
            put[PROJECT] = encode_project(batch.project, store.places)
        store.keep(put, refers)
        encoder.forget(store.tidy(frames))
        try:
            store.commit(note)
        except IlfError as error:
            return _Outcome(encoding, error)
        return _Outcome(encoding, None)

    def _encode(self, state: FrameState, put: dict[str, bytes]) -> frozenset[str]:
        """Add the parts of a state to `put`; return the names of the arrays that it refers to."""
        store, encoder = self.store, self._encoder
        encoded = encoder.encode(state)
        arrays = dict(encoded.arrays)
        lacking = {name for name in encoded.names if name not in arrays and name not in put and store.lacks(name)}
        try:
            arrays |= {name: store.part(name) for name in lacking}
        except IlfError:  # the project file has changed
            encoder.forget(lacking)
            encoded = encoder.encode(state)
            arrays |= encoded.arrays
        put |= arrays | {frame_part(state.id): encoded.frame, thumbnail_part(state.id): thumbnail(state)}
        return encoded.names
