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
from ...state.parts import Part
from ...state.workspace import Entry
from ...widgets.file_choice import ask_path, last_folder, remember_folder
from ...widgets.notices import ACCEPT, DESTROY, ask
from ...work.steps import Steps, go_on, in_steps
from ..context import Context, Feature
from .opening import Opening
from .saving import Saving

if TYPE_CHECKING:
    from .closing import CloseDialog

_PROGRAM = "ILF Studio"
_FOLDER_KEY = "project/folder"
_FILES = f"Project of ILF Studio (*{PROJECT_SUFFIX})"
_NEW, _REPLACE, _INCLUDE = "&New project", "&Replace", "&Include them"
_QUESTION = QMessageBox.Icon.Question
_INCLUDED = (
    "With them, the project can be opened on any computer; otherwise it has their paths and hashes. Recordings are "
    "never included."
)


class ProjectFeature(Feature):
    """The project of the window; a window has exactly one."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, loader = context.workspace, context.loader
        self.present = context.recorder.present
        self.saving, self.opening = Saving(context), Opening(context, self.left)
        self.discard_silently = False
        """Whether to close without asking; for headless use."""
        self.question: CloseDialog | None = None
        """The open question about unsaved work; None for none."""
        self._leaves = False
        loader.replace = lambda entries, then: self.ask_remove(entries, then)
        loader.replayed.connect(lambda _: self.present.mark_extraction())
        loader.opening_failed.connect(self._note_failure)
        self.opening.opened.connect(self._note_opened)
        self.saving.saved.connect(self._note_saved)
        also = workspace.project_touched, workspace.undo_group.cleanChanged, self.saving.changed
        for name, offered in (("show_project", "Show in folder"), ("save_project_as", "Save elsewhere…")):
            context.actions[name].setIconText(offered)
        context.refresh.add("title", self._show_title, Part.FRAME | Part.LIST | Part.CONTENT, also=also)

    # commands

    @command("new_project", "&New project", icon="ph.file-plus")
    @in_steps
    def new(self) -> Steps[None]:
        """Close all frames, and start an empty project."""
        if (yield from self.left("a new project is started")):
            yield from self.opening.begin()

    @command("save_project", "&Save project", icon="ph.floppy-disk", keys="Ctrl+S", needs=Need.LISTED)
    def save(self) -> None:
        """Save all frames with the work on them."""
        go_on(self._saved())

    @command("save_project_as", "Save project &as…", keys="Ctrl+Shift+S", needs=Need.LISTED)
    def save_as(self) -> None:
        """Save all frames with the work on them to another file, optionally with the frames' own files."""
        go_on(self._saved(elsewhere=True))

    # closing

    def may_close(self) -> bool:
        """Whether the window may close. If the user is asked first, the window closes after the answer."""
        asked = False

        @in_steps
        def leave() -> Steps[None]:
            self._leaves = yield from self.left("the window closes")
            if self._leaves and asked:
                self.context.window.close()

        if not self._leaves:
            leave()
            asked = True
        return self._leaves

    def shutdown(self) -> None:
        """Close the project's file."""
        self.present.release()
        self.context.recorder.store.set_project(None, Places())

    @in_steps
    def close_frame(self, entry: Entry) -> Steps[None]:
        """Close a frame, after asking about unsaved work; if the project file contains it, it stays in the list in
        that state."""
        if not (yield from self.left("the frame is closed", entry)):
            return
        if self.present.saved_summary(entry) is not None:
            yield partial(self.context.recorder.revert, [entry.id])
        summary = self.present.saved_summary(entry)
        if entry.document is None or summary is None:
            self.workspace.remove_entries([entry])
            return
        self.workspace.unload(entry.document)
        entry.set_unsaved(False)
        entry.set_summary(summary)

    @in_steps
    def ask_remove(self, entries: Sequence[Entry], then: Callable[[], None]) -> Steps[None]:
        """Call `then` if frames may be removed from the project: at once if there is no work on them."""
        stored = self.context.recorder.store.project
        kept = set() if stored is None else set(stored.names())
        worked = [
            entry.name
            for entry in entries
            if entry.unsaved or entry.document in self.context.runs.running or frame_part(entry.id) in kept
        ]
        if worked and not self.discard_silently:
            names = worked[0] if len(worked) == 1 else f"{len(worked)} frames"
            text = f"The work on {names} is removed, too. This cannot be undone."
            more = "The project file keeps it until the project is saved the next time."
            answers = [("&Remove", DESTROY)]
            if not (yield partial(ask, self.context.window, "Remove from the project?", text, more, answers)):
                return
        then()

    def left(self, what: str, only: Entry | None = None) -> Steps[bool]:
        """Return whether a frame, or all with the project, may be closed, after asking about unsaved work. `what` is
        about to happen, such as "the window closes"."""
        from .closing import CloseDialog  # made on use

        take_typed()
        if self.discard_silently:
            return True
        yield self.saving.when_done
        entries = [*self.workspace.entries] if only is None else [only]
        documents = {entry.document for entry in entries}
        rows = {entry.id: (entry.name, work) for entry in entries if (work := self._work_on(entry))}
        if only is None and (words := self.present.words()):
            rows[""] = "The project itself", words

        def others() -> list[str]:
            return [
                f"{way.what[:1].upper()}{way.what[1:]} is in progress: it is stopped, and what is unfinished is lost."
                for way in self.context.pending_work()
                if (only is None if way.about is None else way.about in documents)
            ]

        if not (rows or others()):
            return True
        if self.question is not None:
            self.question.raise_()
            return False
        self.question = CloseDialog(what, rows, others, self.context.runs, self._saved, self.context.window)
        may: bool = yield self.question.ask
        self.question = None
        return may

    def _work_on(self, entry: Entry) -> str:
        """Describe the unsaved work and the run of a frame, such as "3 edits, 1 run"; "" for none."""
        texts, runs = [entry.unsaved_summary()], self.context.runs
        if entry.document in runs.running:
            texts.append(f"a run is in progress ({runs.of(entry.document).share_done:.0%})")
        return ", ".join(filter(None, texts))

    # what is opened later

    @in_steps
    def join(self, place: Path, look: Callable[[], object], then: Callable[[], None]) -> Steps[None]:
        """Open a file or folder; ask first if the project is that of another folder, and has a file. `look` raises what
        is wrong with it: for nothing, nobody is asked, and no project closed."""
        if self.opening.is_foreign(place) and not self.discard_silently:
            if self._has_file() or self.present.unsaved:
                yield partial(self.context.loader.read, f"Opening {place.name}", look)
                text = f"{place.name} is not in the folder of the project {self.present.name}."
                more, title = "A new project closes its frames first.", "Add to the project?"
                answers = ("&Add to it", ACCEPT), (_NEW, ACCEPT)
                answer = yield partial(ask, self.context.window, title, text, more, answers, default=1, icon=_QUESTION)
                if not answer or (answer == _NEW and not (yield from self.left("a new project is started"))):
                    return
                if answer == _NEW:
                    yield from self.opening.begin()
            else:
                self.opening.detach()
        then()

    # saving

    def _has_file(self) -> bool:
        return self.present.path is not None and self.present.path.exists()

    @command(
        "show_project",
        "Show project in &folder",
        icon="ph.folder-open",
        why_off=lambda self: "" if self._has_file() else "The project is not saved yet.",
    )
    def _show_folder(self) -> None:
        """Show the folder of the project's file."""
        if self.present.path is not None:
            QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.present.path.parent)))

    def _saved(self, only: frozenset[str] | None = None, elsewhere: bool = False) -> Steps[bool]:
        """Save all frames, or some by their ids, to the project's file, or to one that is asked for: `elsewhere`, or if
        there is none that may be replaced. Return whether that was done."""
        yield self.saving.when_done
        present, window = self.present, self.context.window
        path, embed = present.path, None
        if present.read_only and not elsewhere:
            self.notes.show_message(present.read_only)
        elif path is not None and not elsewhere and present.changed_on_disk():
            text = f"Another window or program has changed, moved or deleted {path.name}."
            more = "The project as it is in this window takes the place of whatever is there now."
            answers = (_REPLACE, DESTROY), ("Save &as…", ACCEPT)
            answer = yield partial(ask, window, "Replace the project?", text, more, answers, default=1)
            if not answer:
                return False
            elsewhere = answer != _REPLACE
        if elsewhere or path is None or present.read_only:
            path = self._asked_path()
            if path is None:
                return False
            title, text = "Include the frames' files?", "Include the colour and depth files of all frames?"
            answers = (_INCLUDE, ACCEPT), ("&Leave them out", ACCEPT)
            embedded = any(name.startswith("sources/") for name in self.context.recorder.store.names())
            answer = yield partial(
                ask, window, title, text, _INCLUDED, answers, default=int(not embedded), icon=_QUESTION
            )
            if not answer:
                return False
            embed = answer == _INCLUDE
        return bool((yield partial(self.saving.save, path, embed, only)))

    def _asked_path(self) -> Path | None:
        """Return the file that the user chooses for the project; None for none."""
        first = next(iter(self.workspace.entries), None)
        name = self.present.name or ("project" if first is None else first.name)
        proposed = self.present.path or Path(last_folder(_FOLDER_KEY), f"{as_file_name(name)}{PROJECT_SUFFIX}")
        path = ask_path(self.context.window, "Save project as", str(proposed), _FILES)
        if not path:
            return None
        remember_folder(_FOLDER_KEY, path)
        return Path(path).absolute()

    # messages

    def _note_opened(self, opened: OpenedProject) -> None:
        note_opened(opened.path)
        count = len(opened.project.frames)
        self.notes.show_message(f"Opened {opened.path.name}: {counted(count, 'frame')}.")
        self.notes.warn(
            f"Opened {opened.path.name}", [text for text in (*opened.problems, self.present.read_only) if text]
        )

    def _note_failure(self, entry: Entry, error: Exception) -> None:
        from .missing import ask_how_to_open  # made on use

        ask_how_to_open(self.context, entry, error)

    def _note_saved(self, path: Path, problems: Sequence[str]) -> None:
        note_opened(path)
        self.opening.note_saved(path)
        count, size = len(self.workspace.entries), path.stat().st_size / 1e6
        actions = self.context.actions
        actions.refresh()
        self.notes.offer(
            f"Saved {counted(count, 'frame')} to {path} ({size:.1f} MB).",
            actions["show_project"],
            actions["save_project_as"],
        )
        self.notes.warn("Saved, but not everything as requested", problems)

    def _show_title(self) -> None:
        workspace, window = self.workspace, self.context.window
        names = [self.present.name]
        if workspace.shown is not None:
            view = " (depth camera's view)" if workspace.current.frame.brought is not None else ""
            names.append(f"{workspace.current.name}{view}")
        name = " — ".join(filter(None, names))
        window.setWindowTitle(f"{name}[*] - {_PROGRAM}" if name else _PROGRAM)
        window.setWindowModified(bool(name) and self.present.unsaved)
