"""Opening frames and extracting their blocks, off the GUI's thread and one after the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from gui.session import Session
from gui.worker import Worker
from gui.workspace import Workspace
from ilf.ebs import Extraction, extract
from ilf.errors import IlfError
from ilf.io import load_frame
from ilf.parameters import BlockParameters


@dataclass(frozen=True)
class FrameSource:
    """What to open: a folder with meta.json, or a colour file with its depth file.

    `depth_units` are file units per metre; `intrinsics` anything that `ilf.load_frame` takes.
    """

    rgb: str
    depth: str | None = None
    depth_units: float | None = None
    intrinsics: object = None

    @property
    def key(self) -> str:
        """Tells frames apart: the path of what holds the depth."""
        return str(Path(self.depth or self.rgb).absolute())


@dataclass(frozen=True)
class _Work:
    source: FrameSource | None
    session: Session | None


@dataclass(frozen=True)
class _Outcome:
    session: Session
    opened: bool
    extraction: Extraction
    parameters: BlockParameters


class FrameLoader(QObject):
    """A queue of frames to open and extractions to make.

    Signals
    -------
    busy_changed(str)
        What is being done, or "" when idle.
    extracted(object)
        The Extraction of the session that has just been opened or extracted again.
    failed(str, object)
        What was tried, and the exception.
    """

    busy_changed = Signal(str)
    extracted = Signal(object, object)
    failed = Signal(str, object)
    idle = Signal()

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._queue: deque[_Work] = deque()
        self._present = ""
        self._worker = Worker(self)
        self._worker.finished.connect(self._take)
        self._worker.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether anything is under way or waiting."""
        return self._worker.busy or bool(self._queue)

    def open(self, source: FrameSource) -> None:
        """Read a frame, extract its blocks and show it; a frame that is open already is just shown."""
        for session in self._workspace.sessions:
            if session.source == source.key:
                self._workspace.show_session(session)
                return
        self._queue.append(_Work(source, None))
        self._next()

    def extract(self, session: Session) -> None:
        """Extract the blocks of an open frame again, with the workspace's parameters."""
        self._queue.append(_Work(None, session))
        self._next()

    def shutdown(self) -> bool:
        """Stop before the window closes. True if the thread has ended."""
        self._queue.clear()
        return self._worker.shutdown()

    def _next(self) -> None:
        if self._worker.busy:
            return
        if not self._queue:
            self.busy_changed.emit("")
            self.idle.emit()
            return
        work = self._queue.popleft()
        parameters = self._workspace.extraction_parameters
        if work.source is not None:
            self._present = f"Open {Path(work.source.depth or work.source.rgb).name}"
        elif work.session is not None:
            self._present = f"Extract blocks of {work.session.name}"
        self.busy_changed.emit(self._present)

        def job() -> Generator[None, None, _Outcome]:
            session = work.session or _open(work.source)
            yield None
            return _Outcome(session, work.session is None, extract(session.frame, parameters), parameters)

        self._worker.start(job)

    def _take(self, outcome: _Outcome) -> None:
        if outcome.opened:
            self._workspace.set_extracted(outcome.session, outcome.extraction.blocks, outcome.parameters)
            self._workspace.add_session(outcome.session)
        elif outcome.session in self._workspace.sessions:
            self._workspace.set_extracted(outcome.session, outcome.extraction.blocks, outcome.parameters)
        self.extracted.emit(outcome.session, outcome.extraction)
        self._next()

    def _fail(self, error: Exception) -> None:
        what = self._present
        self.failed.emit(what, error)
        self._next()


def _open(source: FrameSource | None) -> Session:
    if source is None:
        raise IlfError("There is nothing to open.")
    frame = load_frame(source.rgb, source.depth, depth_units=source.depth_units, intrinsics=source.intrinsics)
    return Session(frame, source.key)
