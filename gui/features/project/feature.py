"""The project of the window: new, opened, saved and closed, by commands, by dropping a file, and at exit."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QMessageBox, QToolBar

from ilf._runtime.formatting import counted
from ilf._runtime.named_places import note_opened
from ilf.project.archive import Archive
from ilf.project.file import OpenedProject
from ilf.project.missing_files import folder_projects_dir
from ilf.project.state_codec import UnreadableFrame

from ...base import theme
from ...base.commands import command
from ...base.needs import Need
from ...project.current_project import CurrentProject, source_of
from ...state.document import Document
from ...state.entries import Entry
from ...state.parts import Part
from ...widgets.basics import open_once
from ...widgets.notices import ACCEPT, DESTROY, ask
from ..context import Context, Feature
from ..documents.feature import DocumentsFeature
from ..menus import insert_menu
from .asking import ask_to_open, ask_to_open_anew
from .opening import FolderProjects, Opening
from .recent import RecentMenu, RecentOrigins
from .saving import SaveRequest, Saving
from .view_state import ViewState

if TYPE_CHECKING:
    from .closing import Closing
    from .missing import Missing

_PROGRAM = "ILF Studio"


class ProjectFeature(Feature):
    """The project of the window; a window has exactly one."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace = context.workspace
        self.present = CurrentProject(workspace, self)
        self.view = ViewState(workspace, context.views, context.refresh)
        self.saving = Saving(context, self.present, self.view)
        self.opening = Opening(context, self.present, self.view)
        self.folders = FolderProjects(context, self.present, self.open)
        self._leaves = False
        self.recent = RecentMenu(
            "Open recent pro&ject",
            RecentOrigins("projects", context.panels.persistent),
            self._open_recent,
            context.window,
        )
        documents = context.feature(DocumentsFeature)
        documents.project_requested.connect(self.open)
        documents.leave = self._leave_frames
        documents.remove = lambda entries, then: self.closing.remove(entries, then)
        documents.close = self._close_frame
        documents.join = self._join
        documents.saved_share = lambda: self.saving.share if self.saving.busy else None
        self.saving.changed.connect(documents.exporting_changed)
        context.recorder.is_unsaved = lambda: self.present.unsaved
        context.loader.replayed.connect(lambda _: self.present.mark_extraction_saved())
        context.loader.incomplete.connect(self._tell_incomplete)
        context.loader.opening_failed.connect(self._offer_anew)
        context.loader.not_allowed.connect(partial(ask_to_open, context.window))
        self.opening.opened.connect(self._tell_opened)
        self.opening.opened.connect(lambda opened: self.missing.check(opened))
        context.loader.opening_failed.connect(lambda entry, error: self.missing.note_failure(entry, error))
        self.opening.opened.connect(self.folders.note_opened)
        self.saving.saved.connect(lambda path, _: self.folders.note_saved(path))
        self.saving.saved.connect(lambda path, _: note_opened(path))
        self.opening.opened.connect(lambda opened: note_opened(opened.path))
        self.saving.saved.connect(self._tell_saved)
        self.saving.failed.connect(lambda error: context.notes.report("The project is not saved", error))
        context.refresh.add(
            "title",
            self._show_title,
            Part.FRAME | Part.LIST | Part.CONTENT,
            also=(
                workspace.project_touched,
                workspace.undo_group.cleanChanged,
                self.saving.changed,
            ),
        )

    @cached_property
    def closing(self) -> Closing:
        """Asks before work would be lost; made on use."""
        from .closing import Closing

        return Closing(self.context, self.present, self.saving, self._save)

    @cached_property
    def missing(self) -> Missing:
        """Checks the files of frames; made on use."""
        from .missing import Missing

        return Missing(self.context, self.present)

    def begin(self) -> None:
        """Insert the menu of recent projects and the button *Save*."""
        self.context.actions["show_project"].setIconText("Show in folder")
        self.context.actions["save_project_as"].setIconText("Save elsewhere…")
        self.recent.setIcon(theme.icon("ph.clock-counter-clockwise", self.recent.palette()))
        insert_menu(self.context.window.menuBar(), self.recent, self.context.actions["new_project"])
        self.recent.fill()
        bar, actions = self.context.window.findChild(QToolBar, "Tools"), self.context.actions
        if isinstance(bar, QToolBar):
            bar.insertAction(actions["export"], actions["save_project"])

    # commands

    @command("new_project", "&New project", icon="ph.file-plus")
    def new(self) -> None:
        """Close all frames, and start an empty project."""
        self._leave_project("a new project is started", self._begin)

    def open(self, path: Path) -> None:
        """Open a project, replacing the current one."""
        self.opening.open(path.absolute(), lambda take: self._leave_project(f"{path.name} is opened", take))

    @command("save_project", "&Save project", icon="ph.floppy-disk", keys="Ctrl+S", needs=Need.LISTED)
    def save(self) -> None:
        """Save all frames with the work on them."""
        self.saving.when_done(lambda: self._save(None, lambda done: None))

    @command("save_project_as", "Save project &as…", keys="Ctrl+Shift+S", needs=Need.LISTED)
    def save_as(self) -> None:
        """Save all frames with the work on them to another file, optionally with the frames' own files."""
        self._save_as("", None, lambda done: None)

    # closing

    def may_close(self) -> bool:
        """Whether the window may close. If the user is asked first, the window closes after the answer."""
        asked = False

        def go() -> None:
            self._leaves = True
            if asked:
                self.context.window.close()

        if not self._leaves:
            self.closing.leave(list(self.context.workspace.entries), True, "the window closes", go)
            asked = True
        return self._leaves

    def shutdown(self) -> None:
        """Close the project's file."""
        self.present.release()
        if isinstance(self.context.recorder.store.project, Archive):
            self.context.recorder.store.project.close()

    def _close_frame(self, entry: Entry) -> None:
        """Close a frame; if the project file contains it, it stays in the list in that state."""
        workspace = self.context.workspace

        def close() -> None:
            summary = self.present.saved_summary(entry)
            if entry.document is None or summary is None:
                workspace.remove_entries([entry])
                return
            workspace.unload(entry.document)
            entry.set_unsaved(False)
            workspace.entries.set_summary(entry, summary)

        if self.present.saved_summary(entry) is None:
            close()
        else:
            self.context.recorder.revert([entry.id], close)

    def _leave_frames(self, entries: Sequence[Entry], then: Callable[[], None]) -> None:
        what = "the frame is closed" if len(entries) == 1 else f"{len(entries)} frames are closed"
        self.closing.leave(entries, False, what, then)

    def _leave_project(self, what: str, then: Callable[[], None]) -> None:
        self.closing.leave(list(self.context.workspace.entries), True, what, then)

    def _begin(self, then: Callable[[], None] = lambda: None) -> None:
        self.missing.forget()
        self.folders.forget()
        self.opening.begin(then)

    # what is opened later

    def _join(self, place: Path, then: Callable[[], None]) -> None:
        """Open a file or folder; ask first if the project is that of another folder, and has a file."""
        if not self.folders.is_foreign(place) or self.context.feature(DocumentsFeature).discard_silently:
            then()
        elif self._saved_file() or self.present.unsaved:
            self._ask_join(place, then)
        else:
            self.folders.forget()
            self.opening.detach()
            then()

    def _ask_join(self, place: Path, then: Callable[[], None]) -> None:
        text = f"{place.name} is not of the folder whose project is {self.present.name}."

        def begin() -> None:
            self._leave_project("a new project is started", partial(self._begin, then))

        answers = ("&Add to it", ACCEPT, then), ("&New project", ACCEPT, begin)
        more, icon = "A new project closes its frames first.", QMessageBox.Icon.Question
        ask(self.context.window, "Add to the project?", text, more, answers, default=1, icon=icon)

    # saving

    def _saved_file(self) -> bool:
        return self.present.path is not None and self.present.path.exists()

    @command(
        "show_project",
        "Show project in &folder",
        icon="ph.folder-open",
        why_off=lambda self: "" if self._saved_file() else "The project is not saved yet.",
    )
    def _show_folder(self) -> None:
        """Show the folder of the project's file."""
        if self.present.path is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.present.path.parent)))

    def _save(self, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        present = self.present
        if present.path is None or present.read_only:
            self._save_as(present.read_only, only, then)
        elif present.changed_on_disk():
            self._ask_replace(present.path, only, then)
        else:
            self.saving.save(SaveRequest(present.path, None, only, then))

    def _save_as(self, why: str, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        from .save_as import SaveAsDialog, proposed_path  # made on use

        context = self.context
        first = next(iter(context.workspace.entries), None)
        proposed = self.folders.proposed() or proposed_path(
            self.present.name or ("project" if first is None else first.name)
        )
        sources = [source for source in map(source_of, context.workspace.entries) if source is not None]
        embedded = any(name.startswith("sources/") for name in context.recorder.store.all_names())
        dialog = SaveAsDialog(proposed, embedded, sources, why, context.window)
        dialog.rejected.connect(lambda: then(False))
        open_once(dialog, lambda: self.saving.save(SaveRequest(dialog.chosen(), dialog.embed.isChecked(), only, then)))

    def _ask_replace(self, path: Path, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        """Ask whether to replace a file that was changed since it was opened."""
        if path.exists():
            when = f"{datetime.datetime.fromtimestamp(path.stat().st_mtime):%Y-%m-%d %H:%M}"
            title, button = "Replace the project?", "&Replace"
            text = f"{path.name} has been changed by another window or program since it was opened ({when})."
            more = "Replacing it discards the changes saved there meanwhile."
        else:
            title, button = "Write the project again?", "&Write again"
            text = f"{path.name} does not exist any more: it has been moved or deleted since it was opened."
            more = "It can be written again."
        answers = (
            (button, DESTROY, lambda: self.saving.save(SaveRequest(path, None, only, then))),
            ("Save &as…", ACCEPT, lambda: self._save_as("", only, then)),
        )
        ask(self.context.window, title, text, more, answers, default=1, otherwise=lambda: then(False))

    # messages

    def _open_recent(self, origin: object) -> None:
        if isinstance(origin, Path):
            self.open(origin)

    def _note_recent(self, path: Path) -> None:
        """List a project as recent, unless it is in the data folder: there, the folder of its frames opens it."""
        if not path.is_relative_to(folder_projects_dir()):
            self.recent.note(path)

    def _tell_opened(self, opened: OpenedProject) -> None:
        self._note_recent(opened.path)
        count = len(opened.project.frames)
        self.context.notes.show_message(f"Opened {opened.path.name}: {counted(count, 'frame')}.")
        self.context.notes.warn(
            f"Opened {opened.path.name}", [text for text in (*opened.problems, self.present.read_only) if text]
        )

    def _tell_incomplete(self, document: Document, problems: Sequence[str]) -> None:
        self.context.notes.warn(f"{document.name}: opened without some of its files", problems)

    def _offer_anew(self, entry: Entry, error: Exception) -> None:
        """Offer to open the files of a frame whose work cannot be read."""
        source = source_of(entry)
        if isinstance(error, UnreadableFrame) and source is not None:
            again = partial(self.context.loader.open_new, source, f"{entry.name} (anew)")
            ask_to_open_anew(self.context.window, entry.name, error, again)

    def _tell_saved(self, path: Path, problems: Sequence[str]) -> None:
        self._note_recent(path)
        count, size = len(self.context.workspace.entries), path.stat().st_size / 1e6
        actions = self.context.actions
        self.context.actions.refresh()
        self.context.notes.offer(
            f"Saved {counted(count, 'frame')} to {path} ({size:.1f} MB).",
            actions["show_project"],
            actions["save_project_as"],
        )
        self.context.notes.warn("Saved, but not everything as requested", problems)

    def _show_title(self) -> None:
        workspace, window = self.context.workspace, self.context.window
        names = [self.present.name]
        if workspace.has_current:
            view = " (depth camera's view)" if workspace.current.frame.brought is not None else ""
            names.append(f"{workspace.current.name}{view}")
        name = " — ".join(filter(None, names))
        window.setWindowTitle(f"{name}[*] - {_PROGRAM}" if name else _PROGRAM)
        window.setWindowModified(bool(name) and self.present.unsaved)
