"""Frames whose files are missing or have changed: noted, asked for, and looked for."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, Qt

from gui.desk import Desk
from gui.project.whole import source_of
from gui.project_file.missing_dialog import LostRow, MissingDialog
from gui.project_file.present import PresentProject
from gui.state.entries import Entry
from gui.work.worker import Worker
from ilf.frame import InputFile
from ilf.project.file import OpenedProject
from ilf.project.finding import LostFile, find_in, lost_files, relocated
from ilf.project.sources import ChangedSource, MissingSource

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
