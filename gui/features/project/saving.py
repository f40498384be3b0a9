"""Writing of the project file in a worker thread, from a snapshot that is taken at once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from ilf._runtime.writing import ensure_folder, restrict_to_owner
from ilf.errors import InputError
from ilf.project.archive import Archive, Parts
from ilf.project.file import OpenedProject, open_project, save_project
from ilf.project.missing_files import folder_projects_dir
from ilf.project.project import Project

from ...project.current_project import has_content
from ...project.store import WorkStore
from ...state.document import Document
from ...state.entries import Entry
from ...work.jobs import Worker
from ..context import Context
from .view_state import views_state

_PROGRESS_INTERVAL_MS = 100


@dataclass(frozen=True, eq=False)
class _Snapshot:
    """What is being saved."""

    path: Path
    embed: bool | None
    only: frozenset[str] | None
    then: Callable[[bool], None]
    project: Project
    stamps: Mapping[Document, tuple[int, int, int]]
    unload: Mapping[Entry, int]
    """Frames that are not open, but saved, too -> number of their changes at that time."""
    archive: Parts | None
    """The project file at that time."""


class Saving(QObject):
    """Saves one request at a time; further requests wait.

    Signals
    -------
    changed()
        `busy` or `share` has changed.
    saved(object, object)
        The Path, and a sentence for each thing that was not saved as requested.
    """

    changed = Signal()
    saved = Signal(object, object)

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self._context = context
        self._present = context.recorder.present
        self._afterwards: list[Callable[[], None]] = []
        self._snapshot: _Snapshot | None = None
        self.share = 0.0
        """Written share of the file, 0-1."""
        self._worker = Worker(self, must_finish=True)
        self._pace = QTimer(self, interval=_PROGRESS_INTERVAL_MS)
        self._pace.timeout.connect(self.changed)
        self._worker.finished.connect(self._finish)
        self._worker.failed.connect(self._fail)

    @property
    def busy(self) -> bool:
        """Whether the project is being saved."""
        return self._snapshot is not None

    def save(
        self,
        path: Path,
        embed: bool | None = None,
        only: frozenset[str] | None = None,
        then: Callable[[bool], None] = lambda done: None,
    ) -> None:
        """Save the project, in its state when the requests before are done.

        Parameters
        ----------
        path : Path
        embed : bool, optional
            Whether the project file includes the frames' own files; None for no change.
        only : frozenset of str, optional
            Ids of the frames whose work is saved, the others stay as in the file; None for all.
        then : callable, optional
            Called with whether the project was saved.
        """
        self.when_done(lambda: self._begin(path, embed, only, then))

    def when_done(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as nothing is being saved: at once if nothing is."""
        if self.busy:
            self._afterwards.append(then)
        else:
            then()

    def _begin(self, path: Path, embed: bool | None, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        """Store everything to save in its current state, then write it."""
        workspace, recorder = self._context.workspace, self._context.recorder
        workspace.end_stroke()
        wanted = [entry for entry in workspace.entries if only is None or entry.id in only]
        stamps = {entry.document: entry.document.stamp for entry in wanted if entry.document is not None}
        for document in stamps:
            if has_content(document):
                recorder.keep(document)
        project = self._present.snapshot(views_state(self._context.views), only)
        unload = {entry: entry.changes for entry in wanted if entry.document is None}
        taken = _Snapshot(path, embed, only, then, project, stamps, unload, recorder.store.project)
        self._snapshot, self.share = taken, 0.0
        self._pace.start()
        self.changed.emit()
        recorder.flush(lambda error: self._write(taken, error))

    def _write(self, taken: _Snapshot, error: Exception | None) -> None:
        """Write the file once everything is stored, or report the error."""
        store = self._context.recorder.store
        if error is None and store.project is not taken.archive:
            error = InputError("Another project was opened meanwhile. Save again.")
        if error is not None:
            self._fail(error)
            return

        def job() -> Generator[None, None, tuple[OpenedProject, tuple[str, ...]]]:
            yield None
            problems = self._write_file(taken, store)
            return open_project(taken.path), problems

        self._worker.start(job)

    def _write_file(self, taken: _Snapshot, store: WorkStore) -> tuple[str, ...]:
        """Write the file; called in a worker thread. Returns what was not saved as requested."""
        path, project = taken.path, taken.project
        ensure_folder(path.parent)
        if path.is_relative_to(folder_projects_dir()):  # a folder that the user has not chosen
            restrict_to_owner(folder_projects_dir())
        archive = taken.archive
        with store.held():
            only = {frame.id for frame in project.frames} if taken.only is None else taken.only
            left_out = [frame.id for frame in project.frames if frame.id not in only]
            states, (newer, *written) = store.unsaved(left_out)
            base = [newer, *([] if archive is None else [archive]), *written]
            return save_project(
                path,
                project,
                states,
                base=base,
                places=store.places,
                embed=taken.embed,
                on_part=self._note_share,
            )

    def _note_share(self, done: int, total: int) -> None:
        self.share = done / max(total, 1)

    def _finish(self, outcome: tuple[OpenedProject, tuple[str, ...]]) -> None:
        (opened, problems), taken = outcome, self._snapshot
        self._snapshot = None
        assert taken is not None
        workspace, store = self._context.workspace, self._context.recorder.store
        if isinstance(store.project, Archive) and store.project.path == opened.path:
            opened.close()  # the former one reads the same file
            store.places = opened.places
        else:
            store.set_project(opened.parts, opened.places)
        there = {frame.id for frame in opened.project.frames if frame.has_state}
        for entry in workspace.entries:
            if entry.id in there:
                entry.has_state = True
            if entry.document is None and entry.changes == taken.unload.get(entry):
                entry.set_unsaved(False)
        for document, stamp in taken.stamps.items():
            if document in workspace.open:
                document.note_saved(stamp)
        self._present.take(opened.path, opened.project)
        self._context.recorder.note_project()
        self._tell(lambda: self.saved.emit(opened.path, problems), taken, True)

    def _fail(self, error: Exception) -> None:
        taken, self._snapshot = self._snapshot, None
        if taken is not None:
            self._tell(lambda: self._context.notes.report("The project is not saved", error), taken, False)

    def _tell(self, tell: Callable[[], None], taken: _Snapshot, done: bool) -> None:
        """Tell of the end of a request, after which nothing is being saved, and go on to what waits for it."""
        self._pace.stop()
        self.changed.emit()
        tell()
        taken.then(done)
        while self._afterwards and not self.busy:
            self._afterwards.pop(0)()
