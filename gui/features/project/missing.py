"""Frames whose files are missing or have changed: noted, asked for, and looked for."""

from __future__ import annotations

import datetime
import uuid
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QHBoxLayout,
    QHeaderView,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import grouped
from ilf.data.frame import InputFile
from ilf.project.file import OpenedProject
from ilf.project.finding import LostFile, find_in, lost_files, relocated
from ilf.project.sources import ChangedSource, MissingSource

from ...project.present import PresentProject, source_of
from ...state.entries import Entry
from ...widgets.basics import Message, as_it_is
from ...widgets.work_row import WorkRow
from ...work.jobs import Worker
from ..context import Desk

# The dialog that asks for files that are missing or have changed.

_NUMBER = Qt.ItemDataRole.UserRole
_ABOUT = (
    "Some frames cannot be opened: their files are not where they were, or are not what they were. Say where they are "
    "now; what is found is checked by its content, and whatever else is missing is looked for in the same place. The "
    "work on these frames stays in the project, whatever you do here."
)


@dataclass(frozen=True)
class LostRow:
    """A lost file, with the name of its frame."""

    name: str
    lost: LostFile


class MissingDialog(QDialog):
    """Lost files, with what is known of them, and what can be done.

    Signals
    -------
    file_given(object, object), folder_given(object)
        Where the user says that a LostFile is; where all of them may be.
    new_wished(object)
        The frame of a LostFile that has changed is to be opened anew, without the work.
    cancelled()
        The search is to end.
    """

    file_given = Signal(object, object)
    folder_given = Signal(object)
    new_wished = Signal(object)
    cancelled = Signal()

    def __init__(self, project: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Missing Files of {project}")
        self._rows: list[LostRow] = []
        about = Message(lines=3)
        about.say(_ABOUT, "text")
        self.files = QTreeWidget()
        self.files.setStyleSheet("QTreeView::item { padding: 3px 0; }")
        self.files.setAccessibleName("Missing and changed files")
        self.files.setToolTip("Files that frames were read from, and what is wrong with them")
        self.files.setHeaderLabels(["Frame", "File", "What is wrong"])
        self.files.setRootIsDecorated(False)
        self.files.setUniformRowHeights(True)
        self.files.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        header = self.files.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        for column in (0, 2):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        self.file_button = QPushButton("Locate &file…", autoDefault=False)
        self.file_button.setToolTip("Choose the file that is marked, where it is now; others are looked for beside it")
        self.folder_button = QPushButton("Locate f&older…", autoDefault=False)
        self.folder_button.setToolTip("Choose a folder: all files are looked for in it and below it, by their content")
        self.new_button = QPushButton("Open as &new frame", autoDefault=False)
        self.new_button.setToolTip(
            "Open the changed file as a frame of its own: without the blocks and results, which would not be of it"
        )
        self.work = WorkRow("search")
        self.message = Message(lines=2)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setToolTip("Leave these frames as they are for now")
        buttons.rejected.connect(self.reject)
        self.files.currentItemChanged.connect(lambda *_: self._allow())
        self.file_button.clicked.connect(self._ask_file)
        self.folder_button.clicked.connect(self._ask_folder)
        self.new_button.clicked.connect(self._wish_new)
        self.work.cancelled.connect(self.cancelled)

        row = QHBoxLayout()
        row.setSpacing(8)
        for button in (self.file_button, self.folder_button, self.new_button):
            row.addWidget(button)
        row.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addWidget(self.files, 1)
        layout.addLayout(row)
        layout.addWidget(self.work)
        layout.addWidget(self.message)
        layout.addWidget(buttons)
        self.resize(760, 430)

    def show_rows(self, rows: Sequence[LostRow]) -> None:
        """What is missing now."""
        chosen = self.chosen()
        self._rows = list(rows)
        self.files.clear()
        for number, (name, lost) in enumerate((row.name, row.lost) for row in rows):
            item = QTreeWidgetItem([name, lost.wanted.path, "changed" if lost.changed else "not there"])
            item.setData(0, _NUMBER, number)
            item.setToolTip(1, as_it_is(_details(lost)))
            item.setToolTip(2, as_it_is(_details(lost)))
            self.files.addTopLevelItem(item)
            if number == 0 or lost == chosen:
                self.files.setCurrentItem(item)
        self._allow()

    def chosen(self) -> LostFile | None:
        """The marked file."""
        item = self.files.currentItem()
        number = None if item is None else item.data(0, _NUMBER)
        return None if number is None or number >= len(self._rows) else self._rows[number].lost

    def choose(self, frame: str) -> None:
        """Mark the first file of a frame, by its id."""
        for number, row in enumerate(self._rows):
            if row.lost.frame == frame:
                item = self.files.topLevelItem(number)
                if item is not None:
                    self.files.setCurrentItem(item)
                return

    def show_search(self, share: float | None) -> None:
        """How far the search is; None: none is under way."""
        if share is None:
            self.work.end()
        elif self.work.isHidden():
            self.work.begin()
            self.message.say("")
        else:
            self.work.show_share(share)
        self._allow()

    def _allow(self) -> None:
        lost, idle = self.chosen(), self.work.isHidden()
        self.file_button.setEnabled(idle and lost is not None)
        self.folder_button.setEnabled(idle and bool(self._rows))
        self.new_button.setEnabled(idle and lost is not None and lost.changed is not None)
        if lost is not None and idle and self.message.tone() != "error":
            self.message.say(_details(lost))

    def _ask_file(self) -> None:
        lost = self.chosen()
        if lost is None:
            return
        name = Path(lost.wanted.path).name
        path, _ = QFileDialog.getOpenFileName(self, f"Locate {name}", str(_nearest(lost.wanted.path)))
        if path:
            self.file_given.emit(lost, Path(path))

    def _ask_folder(self) -> None:
        lost = self.chosen()
        start = _nearest(lost.wanted.path if lost is not None else "")
        folder = QFileDialog.getExistingDirectory(self, "Locate Files in Folder", str(start))
        if folder:
            self.folder_given.emit(Path(folder))

    def _wish_new(self) -> None:
        lost = self.chosen()
        if lost is not None and lost.changed is not None:
            self.new_wished.emit(lost)


def _details(lost: LostFile) -> str:
    """What is known of a lost file."""
    wanted = f"{lost.wanted.path}" + (f" (SHA-256 {lost.wanted.sha256[:12]}…)" if lost.wanted.sha256 else "")
    if lost.changed is None:
        return f"{wanted} is not there any more."
    try:
        status = lost.changed.stat()
        when = datetime.datetime.fromtimestamp(status.st_mtime)
        known = f", {grouped(status.st_size)} bytes, of {when:%Y-%m-%d %H:%M},"
    except OSError:
        known = ""
    return (
        f"{lost.changed}{known} has another content than the file that the work was done on. It is not opened in its "
        "place: results would not be of it."
    )


def _nearest(path: str) -> Path:
    """The folder of a path, or the next above it that is there."""
    folder = Path(path).parent
    return next((one for one in (folder, *folder.parents) if one.is_dir()), Path.home())


Search = Callable[[], Generator[float, None, dict[InputFile, Path]]]
_MOST_READ = 500
"""Frames of a project whose files are all read, to see whether they have changed; of larger ones, those that were
written after the project."""
_MISSING, _CHANGED = "files are missing", "files have changed"


class Missing(QObject):
    """Looks in the background whether all files of a project are there, and asks for those that are not."""

    def __init__(self, desk: Desk, present: PresentProject) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._present = present
        self._lost: list[LostFile] = []
        self._wished = ""
        """Id of the frame that could not be shown."""
        self.dialog: MissingDialog | None = None
        self._checker = Worker(self)
        self._checker.finished.connect(self._take_checked)
        self._checker.cancelled.connect(self._ask)
        self._checker.failed.connect(lambda error: desk.notes.report("Missing files", error))
        self._searcher = Worker(self)
        self._searcher.progressed.connect(self._show_search)
        self._searcher.finished.connect(self._take_found)
        self._searcher.cancelled.connect(lambda: self._take_found({}))
        self._searcher.failed.connect(self._fail_search)
        desk.loader.not_opened.connect(self._note_failure)

    @property
    def lost(self) -> tuple[LostFile, ...]:
        """What is missing, as far as that is known."""
        return tuple(self._lost)

    @property
    def busy(self) -> bool:
        """Whether files are being looked for."""
        return self._checker.busy or self._searcher.busy

    def check(self, opened: OpenedProject) -> None:
        """Look for all files of a project that has been opened."""
        self.forget()
        frames, parts, places = opened.project.frames, opened.parts, opened.places
        large = len(frames) > _MOST_READ
        since = opened.path.stat().st_mtime if large and opened.path.exists() else None
        self._checker.start(lambda: lost_files(frames, parts, places, since))

    def forget(self) -> None:
        """Another project takes the place of the present one."""
        self._checker.shutdown()
        self._searcher.shutdown()
        self._lost, self._wished = [], ""
        self._present.forget_unfound()
        if self.dialog is not None:
            self.dialog.reject()

    def give_file(self, lost: LostFile, path: Path) -> None:
        """Say where a file is; others are looked for beside it."""
        self._search(lambda: _one_and_others(lost.wanted, path, self._wanted()))

    def give_folder(self, folder: Path) -> None:
        """Say where all that is missing may be."""
        self._search(lambda: find_in(folder, self._wanted()))

    def open_new(self, lost: LostFile) -> None:
        """Open the files that there are now as a frame of its own."""
        entries = self._desk.workspace.entries
        entry = entries.of(lost.frame)
        source = None if entry is None else source_of(entry)
        if entry is None or source is None or lost.changed is None:
            return
        source = relocated(source, {lost.wanted.path: lost.changed})
        new = Entry(uuid.uuid4().hex, source.key, f"{entry.name} (changed)", source)
        self._desk.workspace.add_entries([new])
        self._desk.loader.open_entry(new)

    def shutdown(self) -> bool:
        """Stop for good. True if no thread is left."""
        ended = [worker.shutdown() for worker in (self._checker, self._searcher)]
        return all(ended)

    # what is missing

    def _take_checked(self, lost: list[LostFile]) -> None:
        for one in lost:
            self._note(one)
        self._ask()

    def _note_failure(self, entry: Entry, error: Exception) -> None:
        """A frame could not be opened."""
        if isinstance(error, MissingSource | ChangedSource):
            self._note(LostFile(entry.id, error.wanted, error.found if isinstance(error, ChangedSource) else None))
        elif all(lost.frame != entry.id for lost in self._lost):
            return
        self._wished = entry.id
        if not self._checker.busy:
            self._ask()

    def _note(self, lost: LostFile) -> None:
        entry = self._desk.workspace.entries.of(lost.frame)
        if entry is None or entry.session is not None:
            return
        if lost not in self._lost:
            self._lost.append(lost)
        self._present.note_unfound(entry)
        self._desk.workspace.note_problem(entry, _CHANGED if lost.changed else _MISSING)

    def _ask(self) -> None:
        """Ask for what is missing, if anything is."""
        if not self._lost:
            return
        if self.dialog is None:
            self.dialog = dialog = MissingDialog(self._present.name, self._desk.window)
            dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
            dialog.file_given.connect(self.give_file)
            dialog.folder_given.connect(self.give_folder)
            dialog.new_wished.connect(self.open_new)
            dialog.cancelled.connect(self._searcher.cancel)
            dialog.finished.connect(self._leave_dialog)
            dialog.open()
        self.dialog.show_rows(self._rows())
        self.dialog.choose(self._wished)

    def _rows(self) -> list[LostRow]:
        entries = self._desk.workspace.entries
        named = ((entries.of(lost.frame), lost) for lost in self._lost)
        return [LostRow(entry.name, lost) for entry, lost in named if entry is not None]

    def _leave_dialog(self) -> None:
        self.dialog = None
        self._searcher.cancel()
        lost = {one.frame for one in self._lost}
        whole = (entry for entry in self._desk.workspace.entries if entry.id not in lost)
        first = next(whole, None)
        if first is not None and not self._desk.workspace.has_session and not self._desk.loader.busy:
            self._desk.loader.open_entry(first)

    # looking for it

    def _wanted(self) -> list[InputFile]:
        return [lost.wanted for lost in self._lost]

    def _search(self, job: Search) -> None:
        if not self._searcher.busy:
            self._searcher.start(job)
            self._show_search([0.0])

    def _show_search(self, shares: Sequence[float]) -> None:
        if self.dialog is not None:
            self.dialog.show_search(shares[-1])

    def _fail_search(self, error: Exception) -> None:
        self._take_found({})
        self._desk.notes.report("Search for files", error)

    def _take_found(self, found: dict[InputFile, Path]) -> None:
        store, dialog = self._desk.store, self.dialog
        given = {wanted.sha256 or wanted.path: path for wanted, path in found.items()}
        store.places = replace(store.places, given={**store.places.given, **given})
        self._desk.recorder.note_project()
        affected = {lost.frame for lost in self._lost if lost.wanted in found}
        self._lost = [lost for lost in self._lost if lost.wanted not in found]
        by_path = {wanted.path: path for wanted, path in found.items()}
        for frame in affected:
            self._bring_back(frame, by_path)
        if dialog is not None:
            dialog.show_search(None)
            dialog.show_rows(self._rows())
            left = len({lost.frame for lost in self._lost})
            if not found:
                dialog.message.say("None of the files is there with the content that the work was done on.", "error")
            elif left:
                miss = "1 frame still misses some" if left == 1 else f"{left} frames still miss some"
                dialog.message.say(f"{_files_found(len(found))}; {miss}.", "text")
            else:
                dialog.accept()
                self._desk.notes.tell(f"{_files_found(len(found))}: all frames can be opened. Save keeps their places.")

    def _bring_back(self, frame: str, found: dict[str, Path]) -> None:
        """Files of a frame have been found."""
        workspace = self._desk.workspace
        entry = workspace.entries.of(frame)
        if entry is None:
            return
        if entry.source is not None:
            entry.source = relocated(entry.source, found)
        if any(lost.frame == frame for lost in self._lost):
            return
        summary = self._present.note_found(entry)
        if summary is not None:
            workspace.entries.set_summary(entry, summary)
        if frame == self._wished or not workspace.has_session:
            self._wished = ""
            self._desk.loader.open_entry(entry)


def _one_and_others(
    wanted: InputFile, path: Path, others: Sequence[InputFile]
) -> Generator[float, None, dict[InputFile, Path]]:
    """A file that the user names, if it is the right one, and what else is beside it."""
    named = replace(wanted, path=path.name)  # it may have another name now
    found = yield from find_in(path.parent, [named, *others], deep=False)
    there = found.pop(named, None)
    return {wanted: there, **found} if there is not None else found


def _files_found(count: int) -> str:
    return f"Found {count} file{'s' * (count != 1)}"
