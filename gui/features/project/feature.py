"""The project of the window: new, opened, saved and closed, by commands, by dropping a file, and at exit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QMessageBox

from ilf._runtime.formatting import counted
from ilf.project.file import OpenedProject
from ilf.project.sources import Places
from ilf.project.state_codec import frame_part
from ilf.run.options import as_file_name
from ilf.sources.named_places import note_opened

from ...base.commands import command, take_typed
from ...base.needs import Need
from ...base.paths import PROJECT_SUFFIX
from ...state.entries import Entry
from ...state.parts import Part
from ...widgets.basics import open_once
from ...widgets.file_choice import ask_path, last_folder, remember_folder
from ...widgets.notices import ACCEPT, DESTROY, ask
from ..context import Context, Feature
from .opening import Opening
from .saving import Saving

if TYPE_CHECKING:
    from .closing import CloseDialog

_PROGRAM = "ILF Studio"
_FOLDER_KEY = "project/folder"
_FILES = f"Project of ILF Studio (*{PROJECT_SUFFIX})"
_INCLUDED = (
    "With them, the project can be opened on any computer; otherwise it has their paths and hashes. Recordings are "
    "never included."
)


class ProjectFeature(Feature):
    """The project of the window; a window has exactly one."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, loader = context.workspace, context.loader
        self.present = context.recorder.present
        self.saving, self.opening = Saving(context), Opening(context, self._leave)
        self.discard_silently = False
        """Whether to close without asking; for headless use."""
        self.question: CloseDialog | None = None
        """The open question about unsaved work; None for none."""
        self._leaves = False
        loader.replace = lambda entries, then: self.ask_remove(entries, then)
        loader.replayed.connect(lambda _: self.present.mark_saved("extraction"))
        loader.opening_failed.connect(self._note_failure)
        self.opening.opened.connect(self._note_opened)
        self.saving.saved.connect(self._note_saved)
        also = workspace.project_touched, workspace.undo_group.cleanChanged, self.saving.changed
        context.refresh.add("title", self._show_title, Part.FRAME | Part.LIST | Part.CONTENT, also=also)

    def begin(self) -> None:
        """Name the commands as they are offered after saving."""
        actions = self.context.actions
        actions["show_project"].setIconText("Show in folder")
        actions["save_project_as"].setIconText("Save elsewhere…")

    # commands

    @command("new_project", "&New project", icon="ph.file-plus")
    def new(self) -> None:
        """Close all frames, and start an empty project."""
        self._leave("a new project is started", self.opening.begin)

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
            self._leave("the window closes", go)
            asked = True
        return self._leaves

    def shutdown(self) -> None:
        """Close the project's file."""
        self.present.release()
        self.context.recorder.store.set_project(None, Places())

    def close_frame(self, entry: Entry) -> None:
        """Close a frame, after asking about unsaved work; if the project file contains it, it stays in the list in
        that state."""
        workspace = self.context.workspace

        def close() -> None:
            summary = self.present.saved_summary(entry)
            if entry.document is None or summary is None:
                workspace.remove_entries([entry])
                return
            workspace.unload(entry.document)
            entry.set_unsaved(False)
            entry.set_summary(summary)

        def go() -> None:
            if self.present.saved_summary(entry) is None:
                close()
            else:
                self.context.recorder.revert([entry.id], close)

        self._leave("the frame is closed", go, entry)

    def ask_remove(self, entries: Sequence[Entry], then: Callable[[], None]) -> None:
        """Call `then` if frames may be removed from the project: at once if there is no work on them."""
        stored = self.context.recorder.store.project
        kept = set() if stored is None else set(stored.names())
        worked = [
            entry.name
            for entry in entries
            if entry.unsaved or entry.document in self.context.runs.running or frame_part(entry.id) in kept
        ]
        if self.discard_silently or not worked:
            then()
            return
        names = worked[0] if len(worked) == 1 else f"{len(worked)} frames"
        text = f"The work on {names} is removed, too. This cannot be undone."
        more = "The project file keeps it until the project is saved the next time."
        ask(self.context.window, "Remove from the project?", text, more, [("&Remove", DESTROY, then)])

    def _leave(self, what: str, then: Callable[[], None], only: Entry | None = None) -> None:
        """Call `then` as soon as a frame, or all with the project, may be closed: at once if there is nothing to ask,
        never if the user cancels. `what` is about to happen, such as "the window closes"."""
        take_typed()
        if self.discard_silently:
            then()
        else:
            self.saving.when_done(lambda: self._ask_leave(what, then, only))

    def _ask_leave(self, what: str, then: Callable[[], None], only: Entry | None) -> None:
        from .closing import CloseDialog  # made on use

        context = self.context
        entries = [*context.workspace.entries] if only is None else [only]
        documents = {entry.document for entry in entries}
        rows = {entry.id: (entry.name, work) for entry in entries if (work := self._work_on(entry))}
        if only is None and (words := self.present.words()):
            rows[""] = "The project itself", words
        others = [
            f"{way.what[:1].upper()}{way.what[1:]} is in progress: it is stopped, and what it has not finished is lost."
            for way in context.pending_work()
            if (only is None if way.about is None else way.about in documents)
        ]
        if not (rows or others):
            then()
        elif self.question is not None:
            self.question.raise_()
        else:
            self.question = dialog = CloseDialog(what, rows, others, context.runs, self._save, context.window)
            dialog.finished.connect(lambda _: setattr(self, "question", None))
            open_once(dialog, then)

    def _work_on(self, entry: Entry) -> str:
        """Describe the unsaved work and the run of a frame, such as "3 edits, 1 run"; "" for none."""
        texts, runs = [entry.unsaved_summary()], self.context.runs
        if entry.document in runs.running:
            texts.append(f"a run is in progress ({runs.of(entry.document).share_done:.0%})")
        return ", ".join(filter(None, texts))

    # what is opened later

    def join(self, place: Path, then: Callable[[], None]) -> None:
        """Open a file or folder; ask first if the project is that of another folder, and has a file."""
        if not self.opening.is_foreign(place) or self.discard_silently:
            then()
        elif self._saved_file() or self.present.unsaved:
            self._ask_join(place, then)
        else:
            self.opening.detach()
            then()

    def _ask_join(self, place: Path, then: Callable[[], None]) -> None:
        text = f"{place.name} is not of the folder whose project is {self.present.name}."

        def begin() -> None:
            self._leave("a new project is started", partial(self.opening.begin, then))

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
            self.saving.save(present.path, None, only, then)

    def _save_as(self, why: str, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        """Ask for the file, and whether it includes the frames' own files. `why` is why the former file cannot be
        replaced; "" if it can."""
        context, first = self.context, next(iter(self.context.workspace.entries), None)
        if why:
            context.notes.show_message(why)
        name = self.present.name or ("project" if first is None else first.name)
        proposed = self.present.path or Path(last_folder(_FOLDER_KEY), f"{as_file_name(name)}{PROJECT_SUFFIX}")
        path = ask_path(context.window, "Save project as", str(proposed), _FILES)
        if not path:
            then(False)
            return
        remember_folder(_FOLDER_KEY, path)

        def save(embed: bool) -> None:
            self.saving.save(Path(path).absolute(), embed, only, then)

        embedded = any(name.startswith("sources/") for name in context.recorder.store.names())
        answers = ("&Include them", ACCEPT, partial(save, True)), ("&Leave them out", ACCEPT, partial(save, False))
        title, text = "Include the frames' files?", "Include the colour and depth files of all frames?"
        ask(
            context.window,
            title,
            text,
            _INCLUDED,
            answers,
            default=int(not embedded),
            otherwise=partial(then, False),
            icon=QMessageBox.Icon.Question,
        )

    def _ask_replace(self, path: Path, only: frozenset[str] | None, then: Callable[[bool], None]) -> None:
        """Ask whether to replace a file that is another one than was opened, or gone."""
        text = f"Another window or program has changed, moved or deleted {path.name}."
        answers = (
            ("&Replace", DESTROY, lambda: self.saving.save(path, None, only, then)),
            ("Save &as…", ACCEPT, lambda: self._save_as("", only, then)),
        )
        more = "The project as it is in this window takes the place of whatever is there now."
        ask(self.context.window, "Replace the project?", text, more, answers, default=1, otherwise=partial(then, False))

    # messages

    def _note_opened(self, opened: OpenedProject) -> None:
        note_opened(opened.path)
        count = len(opened.project.frames)
        self.context.notes.show_message(f"Opened {opened.path.name}: {counted(count, 'frame')}.")
        self.context.notes.warn(
            f"Opened {opened.path.name}", [text for text in (*opened.problems, self.present.read_only) if text]
        )

    def _note_failure(self, entry: Entry, error: Exception) -> None:
        from .missing import ask_how_to_open  # made on use

        ask_how_to_open(self.context, entry, error)

    def _note_saved(self, path: Path, problems: Sequence[str]) -> None:
        note_opened(path)
        self.opening.note_saved(path)
        count, size = len(self.context.workspace.entries), path.stat().st_size / 1e6
        actions = self.context.actions
        actions.refresh()
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
