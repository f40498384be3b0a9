"""Autosave: writes the window's changes to its folder, in a background thread."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator
from weakref import WeakSet

from PySide6.QtCore import QObject, QTimer, Signal

from ilf.errors import IlfError
from ilf.project.project import FrameSummary
from ilf.project.store import WorkHeader

from ..state.document import Document
from ..state.workspace import Workspace
from ..work.jobs import Worker
from .current_project import CurrentProject, project_of
from .store import WorkStore

AFTER_MS = 2000
"""Time [ms] from a change to its storing, with all that follow until then."""
_STROKE_MS = 40
_RETRY_MS = 4000

Then = Callable[[Exception | None], None]
_Outcome = tuple[Exception | None, Exception | None]
"""Errors of encoding and of writing, None for none."""


class Recorder(QObject):
    """Stores changes in the autosave, one complete batch at a time, always the newest state.

    Signals
    -------
    kept()
        The autosave contains all changes.
    failed(object)
        The exception that prevented it. It is retried automatically.
    """

    kept = Signal()
    failed = Signal(object)

    def __init__(self, workspace: Workspace, store: WorkStore, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.present = CurrentProject(workspace)
        """The project, of which it notes the file and whether it lacks changes."""
        self._workspace = workspace
        self.store = store
        self._touched = WeakSet[Document]()
        self._project_touched = True
        """Whether the list of frames and the shared settings are to be written."""
        self._again = False
        """Whether to write again after what is being written."""
        self._summaries: dict[str, FrameSummary] = {}
        """Those of changed frames, by id, as they were taken last: the list of frames has them, too."""
        self._waiting: list[Then] = []
        self._called: list[Then] = []
        self._automatic = False
        workspace.touched.connect(self._note_touched)
        workspace.project_touched.connect(self.note_project)
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._take)
        self._worker = Worker(self, must_finish=True)
        self._worker.finished.connect(self._finish)
        self._worker.failed.connect(lambda error: self._finish((error, None)))

    def start(self) -> None:
        """Store changes automatically from now on, not only on `flush` and `keep`."""
        self._automatic = True

    def flush(self, then: Then) -> None:
        """Store all changes now. When they are written, or in memory if they cannot be, call `then` with None, or with
        the exception that prevented storing a frame."""
        self._waiting.append(then)
        self._workspace.end_stroke()
        self._take()

    def revert(self, frames: Collection[str], then: Callable[[], None]) -> None:
        """Discard the stored states of these frames in favour of those in the project file; then call `then`."""

        def drop(_: Exception | None) -> None:
            self.store.revert(frames)
            then()
            self.note_project()  # remove what is written of them, too

        self.flush(drop)

    def keep(self, document: Document) -> None:
        """Store a frame that is about to be closed: its state can be read from now on."""
        self._touched.add(document)
        self._workspace.end_stroke()
        self._take()

    def note_project(self) -> None:
        """Note a change of the list of frames, of the shared settings, or of the saved state."""
        self._project_touched = True
        self._schedule()

    def shutdown(self) -> bool:
        """Stop permanently, before the window closes. True if the thread has ended."""
        self._timer.stop()
        return self._worker.shutdown()

    def _note_touched(self, document: Document) -> None:
        self._touched.add(document)
        self._schedule()

    def _schedule(self) -> None:
        if self._automatic and not self._timer.isActive():
            self._timer.start(AFTER_MS)

    def _take(self) -> None:
        """Take a snapshot of all changes; it is written after the previous one."""
        if self._workspace.stroke_in_progress:  # a stroke is stored completely or not at all
            self._timer.start(_STROKE_MS)
            return
        self._timer.stop()
        for document in self._workspace.open:
            if document in self._touched:
                self.store.put(document.snapshot())
                entry = self._workspace.entries.of(document.id)
                if entry is not None and self._summaries.get(entry.id) != entry.summary:
                    self._summaries[entry.id] = entry.summary
                    self._project_touched = True
        self._touched.clear()
        self._start()

    def _start(self) -> None:
        self._again = self._worker.busy
        if self._again:
            return
        self._called, self._waiting = self._waiting, []
        project = project_of(self._workspace) if self._project_touched else None
        self._project_touched = False
        frames = frozenset(entry.id for entry in self._workspace.entries)
        unsaved = tuple(entry.id for entry in self._workspace.entries if entry.unsaved)
        header = WorkHeader(self.present.file, self.present.unsaved, unsaved)

        def job() -> Generator[None, None, _Outcome]:
            yield None
            try:
                return self.store.write(project, frames, header), None
            except IlfError as error:
                return None, error

        self._worker.start(job)

    def _finish(self, outcome: _Outcome) -> None:
        called, self._called = self._called, []
        for then in called:
            then(outcome[0])
        error = outcome[0] or outcome[1]
        if error is not None:
            self._project_touched = True
        lost, self.store.lost = self.store.lost, False
        if lost:
            self._touched.update(self._workspace.open)
            self._project_touched = True
        if error is not None:
            self._timer.start(_RETRY_MS)
            self.failed.emit(error)
        elif lost:
            self._take()
        elif self._again or not self.store.is_written:
            self._start()
        else:
            self.kept.emit()
