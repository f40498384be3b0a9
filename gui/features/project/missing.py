"""Frames whose files are missing or have changed: detection, and the dialog that asks where they are."""

from __future__ import annotations

import datetime
from collections.abc import Generator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QPushButton,
    QTreeWidgetItem,
    QWidget,
)

from ilf._runtime.formatting import counted, grouped
from ilf.data.frame import InputFile
from ilf.project.file import OpenedProject
from ilf.project.missing_files import MissingFile, locate, missing_files, relocated
from ilf.project.sources import MissingSource
from ilf.sources.named_places import note_opened

from ...project.current_project import source_of
from ...state.entries import Entry
from ...widgets.basics import Message, give_size, literal_text, open_once, row, row_list, stack
from ...widgets.work_row import WorkRow
from ...work.latest_request import LatestRequest
from ..context import Context

# The dialog that asks for files that are missing or have changed.

_FILE = Qt.ItemDataRole.UserRole
_ABOUT = (
    "Some frames cannot be opened: their files have been moved or changed. Locate the folder where they are now, or a "
    "file that has another name: the other files are looked for beside it. Their content is checked. The work on these "
    "frames stays in the project in any case."
)


class MissingFilesDialog(QDialog):
    """Dialog with missing and changed files, and commands to locate them."""

    def __init__(self, project: str, missing: Missing, parent: QWidget) -> None:
        super().__init__(parent)
        self._missing = missing
        self.setWindowTitle(f"Missing Files of {project}" if project else "Missing Files")
        about = Message(lines=3)
        about.show_message(_ABOUT, "text")
        self.files = row_list(
            "Missing and changed files",
            "Missing or changed files of frames, with the problem",
            ["Frame", "File", "Problem"],
            stretched=1,
        )
        self.files.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.file_button = QPushButton("Locate &file…")
        self.file_button.setToolTip("Locate the selected file; the others are looked for in the same folder")
        self.folder_button = QPushButton("Locate f&older…")
        self.folder_button.setToolTip(
            "Choose the folder where the files are now: they are looked for in it by their names and the last parts of "
            "their paths"
        )
        self.new_button = QPushButton("Open as &new frame")
        self.new_button.setToolTip(
            "Open the changed file as a new frame, without the blocks and results of the former file"
        )
        self.work = WorkRow("search")
        self.message = Message(lines=2)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.button(QDialogButtonBox.StandardButton.Close).setToolTip("Close; these frames stay as they are")
        buttons.rejected.connect(self.reject)
        self.files.currentItemChanged.connect(lambda *_: self._describe())
        self.file_button.clicked.connect(self._ask_file)
        self.folder_button.clicked.connect(self._ask_folder)
        self.new_button.clicked.connect(self._open_new)
        self.work.follow(missing.search)
        missing.search.begun.connect(self._begin_search)
        missing.search.ended.connect(self._allow)

        buttons_of_files = row(self.file_button, self.folder_button, self.new_button)
        stack(self, about, self.files, buttons_of_files, self.work, self.message, buttons, stretched=self.files)
        give_size(self, 760, 430)

    def show_files(self, lost: Sequence[tuple[str, MissingFile]], frame: str = "") -> None:
        """Show the lost files with the names of their frames; select the first of a frame, by its id."""
        chosen = next((file for _, file in lost if file.frame == frame), self.chosen())
        self.files.clear()
        for name, file in lost:
            item = QTreeWidgetItem([name, file.wanted.path, "changed" if file.changed else "missing"])
            item.setData(0, _FILE, file)
            for column in (1, 2):
                item.setToolTip(column, literal_text(_details(file)))
            self.files.addTopLevelItem(item)
            if self.files.topLevelItemCount() == 1 or file == chosen:
                self.files.setCurrentItem(item)
        self._describe()

    def chosen(self) -> MissingFile | None:
        """Return the selected file; None for none."""
        item = self.files.currentItem()
        return None if item is None else item.data(0, _FILE)

    def _begin_search(self) -> None:
        self.message.show_message("")
        for button in (self.file_button, self.folder_button, self.new_button):
            button.setEnabled(False)

    def _allow(self) -> None:
        lost, idle = self.chosen(), not self._missing.search.busy
        self.file_button.setEnabled(idle and lost is not None)
        self.folder_button.setEnabled(idle and self.files.topLevelItemCount() > 0)
        self.new_button.setEnabled(idle and lost is not None and lost.changed is not None)

    def _describe(self) -> None:
        lost = self.chosen()
        self._allow()
        if lost is not None and not self._missing.search.busy and self.message.tone() != "error":
            self.message.show_message(_details(lost))

    def _ask_file(self) -> None:
        lost = self.chosen()
        if lost is None:
            return
        name = Path(lost.wanted.path).name
        path, _ = QFileDialog.getOpenFileName(self, f"Locate {name}", str(_nearest(lost.wanted.path)))
        if path:
            self._missing.look(Path(path), lost)

    def _ask_folder(self) -> None:
        lost = self.chosen()
        start = _nearest(lost.wanted.path if lost is not None else "")
        folder = QFileDialog.getExistingDirectory(self, "Locate Folder of the Files", str(start))
        if folder:
            self._missing.look(Path(folder))

    def _open_new(self) -> None:
        lost = self.chosen()
        if lost is not None:
            self._missing.open_new(lost)


def _details(lost: MissingFile) -> str:
    """Describe a lost file."""
    wanted = f"{lost.wanted.path}" + (f" (SHA-256 {lost.wanted.sha256[:12]}…)" if lost.wanted.sha256 else "")
    if lost.changed is None:
        return f"{wanted} does not exist any more."
    try:
        status = lost.changed.stat()
        when = datetime.datetime.fromtimestamp(status.st_mtime)
        known = f", {grouped(status.st_size)} bytes, of {when:%Y-%m-%d %H:%M},"
    except OSError:
        known = ""
    return (
        f"{lost.changed}{known} has a different content than the original file. It is not opened in its place, because "
        "the results would not belong to it."
    )


def _nearest(path: str) -> Path:
    """Return the folder of a path, or its closest existing parent."""
    folder = Path(path).parent
    return next((one for one in (folder, *folder.parents) if one.is_dir()), Path.home())


_MAX_CHECKED = 500
"""Maximum number of frames of a project whose files are all read to detect changes; in larger projects only files
written after the project."""
_MISSING, _CHANGED = "files are missing", "files have changed"


def _check_files(opened: OpenedProject) -> Generator[None, None, list[MissingFile]]:
    """Return the lost files of a project; runs in a worker thread."""
    is_large = len(opened.project.frames) > _MAX_CHECKED
    return missing_files(opened, opened.path.stat().st_mtime if is_large and opened.path.exists() else None)


class Missing(QObject):
    """Checks the files of a project in the background, and asks for missing ones."""

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self._context = context
        self._present = context.recorder.present
        self.lost: list[MissingFile] = []
        """The lost files found so far."""
        self._requested = ""
        """Id of the frame that the user tried to show."""
        self.dialog: MissingFilesDialog | None = None
        self._check = LatestRequest(self, partial(context.notes.report, "Missing files"))
        self._check.ended.connect(self._ask)
        self.search = LatestRequest(self, partial(context.notes.report, "Search for files"))
        """Looks for lost files at possible places."""

    @property
    def busy(self) -> bool:
        """Whether files are being checked or searched for."""
        return self._check.busy or self.search.busy

    def check(self, opened: OpenedProject) -> None:
        """Check all files of an opened project."""
        self.forget()
        self._check.ask(lambda: _check_files(opened), self._take_checked)

    def forget(self) -> None:
        """Stop, and forget the lost files of the current project."""
        self._check.cancel()
        self.search.cancel()
        self.lost, self._requested = [], ""
        if self.dialog is not None:
            self.dialog.reject()

    def look(self, place: Path, lost: MissingFile | None = None) -> None:
        """Look for all lost files in a folder, which may be one of them; or for one at a path, for others beside it."""
        places = self._context.recorder.store.places
        given = {} if lost is None else {lost.wanted.path: place}
        folders = (place, place.parent) if lost is None else (place.parent,)
        places = replace(places, given={**places.given, **given}, folders=folders)
        wanted = list(dict.fromkeys(one.wanted for one in self.lost))
        self.search.ask(lambda: locate(wanted, places), partial(self._take_found, places.folders))

    def open_new(self, lost: MissingFile) -> None:
        """Open the changed files as a new frame."""
        entries = self._context.workspace.entries
        entry = entries.of(lost.frame)
        source = None if entry is None else source_of(entry)
        if entry is None or source is None or lost.changed is None:
            return
        source = relocated(source, {lost.wanted.path: lost.changed})
        self._context.loader.open_new(source, f"{entry.name} (changed)")

    # lost files

    def _take_checked(self, lost: list[MissingFile]) -> None:
        for one in lost:
            self._note(one)

    def note_failure(self, entry: Entry, error: Exception) -> None:
        """Handle a frame that could not be opened."""
        if isinstance(error, MissingSource):
            self._note(MissingFile(entry.id, error.wanted, error.found))
        elif all(lost.frame != entry.id for lost in self.lost):
            return
        self._requested = entry.id
        if not self._check.busy:
            self._ask()

    def _note(self, lost: MissingFile) -> None:
        entry = self._context.workspace.entries.of(lost.frame)
        if entry is None or entry.document is not None:
            return
        if lost not in self.lost:
            self.lost.append(lost)
        self._context.workspace.note_problem(entry, _CHANGED if lost.changed else _MISSING)

    def _ask(self) -> None:
        """Open the dialog if files are lost."""
        if not self.lost:
            return
        if self.dialog is None:
            self.dialog = dialog = MissingFilesDialog(self._present.name, self, self._context.window)
            dialog.finished.connect(self._leave_dialog)
            open_once(dialog)
        self.dialog.show_files(self._named(), self._requested)

    def _named(self) -> list[tuple[str, MissingFile]]:
        """Return the lost files with the names of their frames."""
        entries = self._context.workspace.entries
        found = ((entries.of(lost.frame), lost) for lost in self.lost)
        return [(entry.name, lost) for entry, lost in found if entry is not None]

    def _leave_dialog(self) -> None:
        self.dialog = None
        self.search.cancel()
        lost = {one.frame for one in self.lost}
        whole = (entry for entry in self._context.workspace.entries if entry.id not in lost)
        first = next(whole, None)
        if self._context.workspace.has_current or self._context.loader.busy:
            return
        if first is None:
            self._context.panels.reveal("Frames")  # where they can be opened again
        else:
            self._context.loader.open_entry(first)

    # search

    def _take_found(self, searched: tuple[Path, ...], found: dict[InputFile, Path]) -> None:
        store, dialog = self._context.recorder.store, self.dialog
        note_opened(*found.values())
        given = {wanted.sha256 or wanted.path: path for wanted, path in found.items()}
        # frames that are opened later are looked for there, too
        folders = dict.fromkeys((*store.places.folders, *(searched if found else ())))
        store.places = replace(store.places, given={**store.places.given, **given}, folders=tuple(folders))
        self._context.recorder.note_project()
        affected = {lost.frame for lost in self.lost if lost.wanted in found}
        self.lost = [lost for lost in self.lost if lost.wanted not in found]
        by_path = {wanted.path: path for wanted, path in found.items()}
        for frame in affected:
            self._update_found(frame, by_path)
        if dialog is None:
            return
        dialog.show_files(self._named())
        left, text = len({lost.frame for lost in self.lost}), f"Found {counted(len(found), 'file')}"
        if not found:
            dialog.message.show_message("No file with the original content is there. Choose another folder.", "error")
        elif left:
            dialog.message.show_message(f"{text}; files of {counted(left, 'frame')} are still missing.", "text")
        else:
            dialog.accept()
            self._context.notes.show_message(
                f"{text}: all frames can be opened. Save the project to store the new paths."
            )

    def _update_found(self, frame: str, found: dict[str, Path]) -> None:
        """Update a frame whose files have been found."""
        workspace = self._context.workspace
        entry = workspace.entries.of(frame)
        if entry is None:
            return
        if entry.source is not None:
            entry.source = relocated(entry.source, found)
        if any(lost.frame == frame for lost in self.lost):
            return
        self._present.found_elsewhere = True
        workspace.note_problem(entry, "")
        if frame == self._requested or not workspace.has_current:
            self._requested = ""
            self._context.loader.open_entry(entry)
