"""Writing of the project file in a worker thread, from a snapshot that is taken at once."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, QTimer, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.files import ensure_folder
from ilf._runtime.temporary_files import restrict_to_owner
from ilf.errors import InputError
from ilf.project.archive import Archive, Parts
from ilf.project.file import OpenedProject, open_project, save_project
from ilf.project.missing_files import folder_projects_dir
from ilf.project.project import Project
from ilf.sources.frame_source import FrameSource

from ...base.paths import PROJECT_SUFFIX
from ...project.current_project import CurrentProject, ProjectSettings, has_content
from ...project.store import WorkStore
from ...state.entries import Entry
from ...state.session import Session
from ...widgets.basics import Message, PlainLabel, last_folder
from ...work.jobs import Worker
from ..context import Context
from .view_state import ViewState

_PROGRESS_INTERVAL_MS = 100


@dataclass(frozen=True, eq=False)
class SaveRequest:
    """Request to save the project.

    Attributes
    ----------
    path : Path
    embed : bool or None
        Whether the project file includes the frames' own files; None for no change.
    only : frozenset of str or None
        Ids of the frames whose work is saved, the others stay as in the file; None for all.
    then : callable
        Called with whether the project was saved.
    """

    path: Path
    embed: bool | None = None
    only: frozenset[str] | None = None
    then: Callable[[bool], None] = lambda done: None


@dataclass(frozen=True, eq=False)
class _Snapshot:
    """Snapshot that is being saved."""

    request: SaveRequest
    project: Project
    stamps: Mapping[Session, tuple[int, int, int]]
    unload: Mapping[Entry, int]
    """Frames that are not open, but saved, too -> number of their changes at that time."""
    archive: Parts | None
    """The project file at that time."""
    set: ProjectSettings


class Saving(QObject):
    """Saves one request at a time; further requests wait.

    Signals
    -------
    changed()
        `busy` or `share` has changed.
    saved(object, object)
        The Path, and a sentence for each thing that was not saved as requested.
    failed(object)
        The exception raised while saving.
    """

    changed = Signal()
    saved = Signal(object, object)
    failed = Signal(object)

    def __init__(self, context: Context, present: CurrentProject, view: ViewState) -> None:
        super().__init__(context.window)
        self._context = context
        self._present = present
        self._view = view
        self._waiting: list[SaveRequest] = []
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

    def save(self, request: SaveRequest) -> None:
        """Save the project, in its state when the request is processed."""
        self._waiting.append(request)
        self._next()

    def when_done(self, then: Callable[[], None]) -> None:
        """Call `then` as soon as no request is pending: at once if there is none."""
        if self.busy:
            self._afterwards.append(then)
        else:
            then()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        self._waiting.clear()
        self._afterwards.clear()
        self._pace.stop()
        return self._worker.shutdown()

    def _next(self) -> None:
        if self._snapshot is not None or not self._waiting:
            return
        self._snapshot = self._take(self._waiting.pop(0))
        self.share = 0.0
        self._pace.start()
        self.changed.emit()
        self._context.recorder.flush(self._write)

    def _take(self, request: SaveRequest) -> _Snapshot:
        """Store everything to save in its current state, and return the snapshot."""
        workspace, store = self._context.workspace, self._context.recorder.store
        if workspace.blocks.stroke_in_progress:
            workspace.blocks.prepare_change(workspace.session)
        self._view.remember()
        wanted = [entry for entry in workspace.frames.entries if request.only is None or entry.id in request.only]
        stamps = {entry.session: entry.session.stamp for entry in wanted if entry.session is not None}
        for session in stamps:
            if session.unsaved or has_content(session):
                self._context.recorder.keep(session)
        project = self._present.snapshot(self._view.window_state(), request.only)
        unload = {entry: entry.changes for entry in wanted if entry.session is None}
        return _Snapshot(request, project, stamps, unload, store.project, self._present.current_settings())

    def _write(self, error: Exception | None) -> None:
        """Write the file once everything is stored, or report the error."""
        taken, store = self._snapshot, self._context.recorder.store
        if taken is None:
            return
        if error is None and store.project is not taken.archive:
            error = InputError("Another project was opened meanwhile. Save again.")
        if error is not None:
            self._fail(error)
            return

        def job() -> Generator[None, None, tuple[OpenedProject, tuple[str, ...]]]:
            yield None
            return self._written(taken, store)

        self._worker.start(job)

    def _written(self, taken: _Snapshot, store: WorkStore) -> tuple[OpenedProject, tuple[str, ...]]:
        """Write the file; called in a worker thread."""
        request, project = taken.request, taken.project
        ensure_folder(request.path.parent)
        if request.path.is_relative_to(folder_projects_dir()):  # a folder that the user has not chosen
            restrict_to_owner(folder_projects_dir())
        archive = taken.archive
        with store.held():
            left = (
                [] if request.only is None else [frame.id for frame in project.frames if frame.id not in request.only]
            )
            states, parts = store.unsaved_parts(left)
            base = [parts, *([] if archive is None else [archive])]
            problems = save_project(
                request.path,
                project,
                states,
                base=base,
                places=store.places,
                embed=request.embed,
                on_part=self._note_share,
            )
        return open_project(request.path), problems

    def _note_share(self, done: int, total: int) -> None:
        self.share = done / max(total, 1)

    def _finish(self, outcome: tuple[OpenedProject, tuple[str, ...]]) -> None:
        taken, self._snapshot = self._snapshot, None
        if taken is None:
            return
        opened, problems = outcome
        workspace, store = self._context.workspace, self._context.recorder.store
        former = store.project
        if isinstance(former, Archive) and former.path == opened.path:
            opened.close()  # the former one reads the same file
        else:
            store.project = opened.parts
            if isinstance(former, Archive):
                former.close()
        store.places = opened.places
        there = {frame.id for frame in opened.project.frames if frame.has_state}
        for entry in workspace.frames.entries:
            if entry.id in there:
                entry.has_state = True
            if entry.session is None and entry.changes == taken.unload.get(entry):
                entry.set_unsaved(False)
        for session, stamp in taken.stamps.items():
            if session in workspace.frames.sessions:
                workspace.frames.note_saved(session, stamp)
        self._present.take(opened.path, opened.project, saved=taken.set)
        self._context.recorder.project = str(opened.path)
        self._context.recorder.note_project()
        self._tell(lambda: self.saved.emit(opened.path, problems), taken, True)

    def _fail(self, error: Exception) -> None:
        taken, self._snapshot = self._snapshot, None
        if taken is not None:
            self._tell(lambda: self.failed.emit(error), taken, False)

    def _tell(self, tell: Callable[[], None], taken: _Snapshot, done: bool) -> None:
        self._pace.stop()
        self.changed.emit()
        tell()
        taken.request.then(done)
        self._next()
        while self._afterwards and not self.busy:
            self._afterwards.pop(0)()


# The dialog that asks for the file of a project, and whether to include the frames' own files.

FOLDER_KEY = "project/folder"
_NOT_EMBEDDED = "The frames' files are not included: copy them, too, when you move the project to another computer."
_MAX_SIZED = 500
"""Maximum number of frames whose file sizes are added up for the dialog."""
FILE_FILTER = f"Project of ILF Studio (*{PROJECT_SUFFIX})"


class SaveAsDialog(QDialog):
    """Dialog to choose the project file, and whether it includes the frames' files.

    Parameters
    ----------
    proposed : Path
        Default file.
    embedded : bool
        Whether the project includes the frames' files now.
    sources : collection of FrameSource
        Sources of its frames.
    why : str
        Why the project is not saved to its former file, "" for no message.
    parent : QWidget
    """

    def __init__(
        self, proposed: Path, embedded: bool, sources: Collection[FrameSource], why: str, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Save Project As")
        size = f" ({_words(sum(map(_size_of, sources)))})" if len(sources) <= _MAX_SIZED else ""
        self.path = QLineEdit(str(proposed))
        self.path.setMinimumWidth(380)
        self.path.setToolTip(f"The project file; {PROJECT_SUFFIX} is added if it has no suffix")
        browse = QPushButton("&Browse…", autoDefault=False)
        browse.setToolTip("Choose the file")
        browse.clicked.connect(self._browse)
        self.embed = QCheckBox(f"&Include the frames' own files{size}")
        self.embed.setToolTip(
            "Include the colour, depth and ground truth files of all frames, so that the project can be opened on any "
            "computer; otherwise it contains their paths and hashes. Recordings are never included"
        )
        self.embed.setChecked(embedded)
        self.message = Message(lines=3)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Save | QDialogButtonBox.StandardButton.Cancel)
        self.save_button = buttons.button(QDialogButtonBox.StandardButton.Save)
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self._why = why
        self.path.textChanged.connect(lambda _: self._check())
        self.embed.toggled.connect(lambda _: self._check())

        label = PlainLabel("&File")
        label.setBuddy(self.path)
        row = QHBoxLayout()
        row.setSpacing(8)
        for widget in (label, self.path, browse):
            row.addWidget(widget)
        column = QVBoxLayout(self)
        column.setContentsMargins(14, 14, 14, 14)
        column.setSpacing(10)
        column.addLayout(row)
        column.addWidget(self.embed)
        column.addWidget(self.message)
        column.addStretch(1)
        column.addWidget(buttons)
        self._check()

    def chosen(self) -> Path:
        """Return the file, with its suffix."""
        path = Path(os.path.expanduser(self.path.text().strip())).absolute()
        return path if path.suffix or not path.name else path.with_name(path.name + PROJECT_SUFFIX)

    def accept(self) -> None:
        """Remember the folder."""
        QSettings().setValue(FOLDER_KEY, str(self.chosen().parent))
        super().accept()

    def _browse(self) -> None:
        path, _ = QFileDialog.getSaveFileName(
            self, "Save Project As", str(self.chosen()), FILE_FILTER, options=QFileDialog.Option.DontConfirmOverwrite
        )
        if path:
            self.path.setText(path)

    def _check(self) -> None:
        """Show what is wrong with the file, or that an existing one will be replaced."""
        problem, replaces = "", False
        if not self.path.text().strip():
            problem = "Enter a file name."
        else:
            path = self.chosen()
            if not path.parent.is_dir():
                problem = f"{path.parent} does not exist: create this folder, or choose another."
            elif not os.access(path.parent, os.W_OK):
                problem = f"{path.parent} cannot be written: choose another folder."
            elif path.is_dir():
                problem = f"{path.name or path} is a folder: choose another name."
            elif path.exists() and not os.access(path, os.W_OK):
                problem = f"{path.name} is write-protected: choose another name."
            replaces = not problem and path.exists()
        self.save_button.setEnabled(not problem)
        self.save_button.setText("&Replace" if replaces else "&Save")
        if problem:
            self.message.show_message(problem, "error")
        elif replaces:
            self.message.show_message(f"{self.chosen().name} exists already and will be replaced.", "warning")
        else:
            self.message.show_message(self._why or ("" if self.embed.isChecked() else _NOT_EMBEDDED))


def proposed_path(name: str) -> Path:
    """Return the default file of a project, in the folder of the last one."""
    safe = "".join(letter if letter.isalnum() or letter in "-_. " else "-" for letter in name).strip(" .")
    return Path(last_folder(FOLDER_KEY)) / f"{safe or 'project'}{PROJECT_SUFFIX}"


def _size_of(source: FrameSource) -> int:
    """Return the size of a frame's existing files [bytes]; 0 for recordings, which are never included."""
    size = 0
    if source.frame is not None:
        return size
    try:
        source = source.allowed()
    except InputError:
        return size
    for path in (source.rgb, source.depth, source.options.ground_truth):
        if path is None:
            continue
        try:
            files = [entry for entry in os.scandir(path) if entry.is_file()] if os.path.isdir(path) else [Path(path)]
            size += sum(file.stat().st_size for file in files)
        except OSError:
            continue
    return size


def _words(size: int) -> str:
    return f"{size / 1e6:.0f} MB" if size >= 1e7 else f"{size / 1e6:.1f} MB" if size >= 1e5 else f"{size / 1e3:.0f} kB"
