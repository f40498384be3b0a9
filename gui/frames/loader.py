"""Opening frames and extracting their blocks, off the GUI's thread and one after the other."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, Signal

from gui.extraction.found_blocks import Found, describe_blocks, find
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.worker import Worker
from ilf.completion import prepare
from ilf.frame import RGBDFrame
from ilf.io.frame_source import FrameSource
from ilf.parameters import BlockParameters, preset
from ilf.run import Replay, Run, replay


@dataclass(frozen=True, eq=False)
class _Opened:
    """What a session is made of, in the GUI's thread, where its undo stack must live."""

    run: Run
    origin: FrameSource | Path
    key: str
    again: Replay | None = None
    """The record that the run comes from; None if its blocks are yet to be extracted."""


@dataclass(frozen=True, eq=False)
class _Extracted:
    session: Session
    found: Found


Steps = Generator[_Opened | None, None, Found | _Extracted | None]
Job = Callable[[], Steps]


class FrameLoader(QObject):
    """A queue of frames to open and extractions to make.

    Signals
    -------
    busy_changed()
        `busy` or `present` has changed.
    message(str)
        What an opening or an extraction gave.
    extracted(object)
        What has been Found for the frame that is the present one or about to become it.
    replayed(object)
        A session that has been opened from a record.
    failed(str, object)
        What was tried, and the exception.
    idle()
        Nothing is under way or waiting any more.
    """

    busy_changed = Signal()
    message = Signal(str)
    extracted = Signal(object)
    replayed = Signal(object)
    failed = Signal(str, object)
    idle = Signal()

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._queue: deque[tuple[str, Job]] = deque()
        self._present = ""
        self._done = 0
        """How many have ended since nothing was under way."""
        self._worker = Worker(self)
        self._opening: Session | None = None
        """The frame whose blocks are being extracted for the first time."""
        self._worker.progressed.connect(self._take_opened)
        self._worker.finished.connect(self._take)
        self._worker.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether anything is under way or waiting."""
        return self._worker.busy or bool(self._queue)

    @property
    def present(self) -> str:
        """What is being done; "" when idle."""
        return self._present if self.busy else ""

    @property
    def share_done(self) -> float:
        """Share of what was to be opened or extracted together that is done, 0-1; 0 where it is just one."""
        return self._done / max(self._done + len(self._queue) + self._worker.busy, 1)

    def open(self, source: FrameSource) -> None:
        """Read a frame, show it, and extract its blocks.

        A frame that is open already is just shown; one that is open with other units or intrinsics is read again
        and takes its place.
        """
        if self._shown_already(source, source.key):
            return
        parameters = self._workspace.extraction_parameters
        self._add(f"Open {Path(source.key).name}", lambda: _open(source, parameters))

    def open_run(self, record: Path) -> None:
        """Read a run.json: its frame, blocks and parameters. What it filled comes back by running it."""
        record = Path(os.path.abspath(record))  # whichever way it is named, it is one frame
        if self._shown_already(record, str(record)):
            return
        self._add(f"Open {record.name}", lambda: _open_run(record))

    def _shown_already(self, origin: FrameSource | Path, key: str) -> bool:
        session = self._workspace.session_of(key)
        if session is None or session.origin != origin:
            return False
        self._workspace.show_session(session)
        return True

    def extract(self, session: Session, found: Found | None = None) -> None:
        """Extract the blocks of an open frame again, with the workspace's parameters.

        With `found`, which must be what they give, it need not be done again: the blocks are there at once.
        """
        parameters = self._workspace.extraction_parameters
        frame = session.frame
        if found is not None:
            self._take_extraction(_Extracted(session, found))
        else:
            self._add(f"Extract blocks of {session.name}", lambda: _extract(session, frame, parameters))

    def shutdown(self) -> bool:
        """Stop before the window closes. True if the thread has ended."""
        self._queue.clear()
        return self._worker.shutdown()

    def _add(self, what: str, job: Job) -> None:
        self._queue.append((what, job))
        self._next()

    def _next(self) -> None:
        if self._worker.busy:
            return
        if not self._queue:
            self._done = 0
            self.busy_changed.emit()
            self.idle.emit()
            return
        self._present, job = self._queue.popleft()

        self._worker.start(job)
        self.busy_changed.emit()

    def _take_opened(self, batch: list[_Opened | None]) -> None:
        for opened in batch:
            if opened is not None and not self._shown_already(opened.origin, opened.key):
                self._add_session(opened)

    def _take(self, outcome: Found | _Extracted | None) -> None:
        opening, self._opening = self._opening, None
        self._done += 1
        if isinstance(outcome, Found):
            if opening is not None and opening in self._workspace.sessions:
                self._take_first(opening, outcome)
        elif outcome is not None and outcome.session in self._workspace.sessions:
            self._take_extraction(outcome)
        self._next()

    def _take_first(self, session: Session, found: Found) -> None:
        """The blocks of a frame that has been opened without any."""
        if self._workspace.is_present(session):
            self.extracted.emit(found)
        self._workspace.set_first_blocks(session, found.extraction, found.parameters)
        beside = session.origin.beside() if isinstance(session.origin, FrameSource) else ""
        self._tell_blocks(session, beside, *found.extraction.notes)

    def _take_extraction(self, outcome: _Extracted) -> None:
        session, found = outcome.session, outcome.found
        kept = self._workspace.set_extracted(session, found.extraction, found.parameters)
        if session is self._workspace.session:
            self.extracted.emit(found)
        self._tell_blocks(session, _describe_kept(*kept), *found.extraction.notes)

    def _tell_blocks(self, session: Session, *notes: str) -> None:
        text = f"{session.name}: {describe_blocks(len(session.counts()), session.labels)}."
        self.message.emit(" ".join(filter(None, (text, *notes))))

    def _add_session(self, opened: _Opened) -> None:
        session = Session.of(opened.run, opened.origin, opened.key, opened.again)
        replaced = self._workspace.session_of(opened.key)
        if replaced is not None:
            self._workspace.close_session(replaced)
        self._workspace.add_session(session, None if opened.again is None else opened.run)
        if opened.again is None:
            self._opening = session
        else:
            self._tell_blocks(session, *opened.run.notes)
            self.replayed.emit(session)

    def _fail(self, error: Exception) -> None:
        what, self._opening = self._present, None
        self._done += 1
        self.failed.emit(what, error)
        self._next()


def _describe_kept(locked: int, by_hand: int, all_kept: bool) -> str:
    """What an extraction has left as it was; "" for nothing."""
    counts = [f"{locked} locked"] * (locked > 0) + [f"{by_hand} made by hand"] * (by_hand > 0)
    if not counts:
        return ""
    text = f"Kept: {', '.join(counts)}."
    if all_kept and by_hand:
        text += " Those are all blocks: switch off 'Keep blocks made by hand' to have them extracted anew."
    return text


def _open(source: FrameSource, parameters: BlockParameters) -> Steps:
    frame = source.load()
    no_blocks = np.zeros(frame.shape, np.int32)
    yield _Opened(Run(frame, no_blocks, extraction=parameters), source, source.key)
    found = find(frame, parameters)
    prepare(frame, preset(), parameters)  # here and now, rather than when the first slider is moved
    return found


def _open_run(path: Path) -> Steps:
    again = replay(path)
    yield _Opened(again.run, path, str(path), again)
    return None


def _extract(session: Session, frame: RGBDFrame, parameters: BlockParameters) -> Steps:
    yield None  # so that it can be given up before it has begun
    return _Extracted(session, find(frame, parameters))
