"""Writing of the project file in a worker thread, from a snapshot that is taken at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from ilf._runtime.writing import ensure_folder
from ilf.errors import InputError
from ilf.project.archive import Archive, Parts
from ilf.project.file import OpenedProject, open_project, save_project
from ilf.project.project import Project

from ...project.current_project import has_content
from ...state.document import Document
from ...state.workspace import Entry
from ...work.latest_request import LatestRequest
from ...work.steps import Steps, in_steps
from ..context import Context
from ..layouts import views_state

_PROGRESS_INTERVAL_MS = 100


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
        self._afterwards: list[Callable[[], None]] = []
        self._writer = LatestRequest(self, must_finish=True)
        self.busy = False
        """Whether the project is being saved."""
        self.share = 0.0
        """Written share of the file, 0-1."""
        self._pace = QTimer(self, interval=_PROGRESS_INTERVAL_MS)
        self._pace.timeout.connect(self.changed)

    def when_done(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as nothing is being saved: at once if nothing is."""
        if self.busy:
            self._afterwards.append(then)
        else:
            then()

    @in_steps
    def save(
        self,
        path: Path,
        embed: bool | None = None,
        only: frozenset[str] | None = None,
        then: Callable[[bool], None] = lambda done: None,
    ) -> Steps[None]:
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
        yield self.when_done
        self.busy, self.share = True, 0.0
        self._pace.start()
        self.changed.emit()
        problem: Exception | None = None
        try:
            problems = yield from self._written(path, embed, only)
        except Exception as error:
            problem = error
        self.busy = False
        self._pace.stop()
        self.changed.emit()
        if problem is None:
            self.saved.emit(path, problems)
        else:
            self._context.notes.report("The project is not saved", problem)
        then(problem is None)
        while self._afterwards and not self.busy:
            self._afterwards.pop(0)()

    def _written(self, path: Path, embed: bool | None, only: frozenset[str] | None) -> Steps[Sequence[str]]:
        """Store everything to save in its current state, then write it; return what was not saved as requested."""
        workspace, recorder = self._context.workspace, self._context.recorder
        workspace.end_stroke()
        wanted = [entry for entry in workspace.entries if only is None or entry.id in only]
        stamps = {entry.document: entry.document.stamp for entry in wanted if entry.document is not None}
        for document in stamps:
            if has_content(document):
                recorder.keep(document)
        closed = {entry: entry.changes for entry in wanted if entry.document is None}
        project = recorder.present.snapshot(views_state(self._context.views), only)
        archive = recorder.store.project
        yield recorder.flush
        if recorder.store.project is not archive:
            raise InputError("Another project was opened meanwhile. Save again.")
        left_out = [] if only is None else [frame.id for frame in project.frames if frame.id not in only]
        write = partial(self._write_file, path, project, archive, left_out, embed)
        opened, problems = yield lambda go: self._writer.ask(write, go, go)
        self._take(opened, stamps, closed)
        return problems

    def _write_file(
        self, path: Path, project: Project, archive: Parts | None, left_out: Sequence[str], embed: bool | None
    ) -> tuple[OpenedProject, tuple[str, ...]]:
        """Write the file, and open it; called in a worker thread. Returns also what was not saved as requested."""
        store = self._context.recorder.store
        ensure_folder(path.parent)
        with store.held():
            states, (newer, *written) = store.unsaved(left_out)
            base = [newer, *([] if archive is None else [archive]), *written]
            problems = save_project(
                path, project, states, base=base, places=store.places, embed=embed, on_part=self._note_share
            )
        return open_project(path), problems

    def _note_share(self, done: int, total: int) -> None:
        self.share = done / max(total, 1)

    def _take(
        self, opened: OpenedProject, stamps: Mapping[Document, tuple[int, int, int]], closed: Mapping[Entry, int]
    ) -> None:
        """Note what the file has: documents with these stamps, and frames that were closed with these changes."""
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
            if entry.document is None and entry.changes == closed.get(entry):
                entry.set_unsaved(False)
        for document, stamp in stamps.items():
            if document in workspace.open:
                document.note_saved(stamp)
        self._context.recorder.present.take(opened.path, opened.project)
        self._context.recorder.note_project()
