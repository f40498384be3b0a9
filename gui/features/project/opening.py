"""Opening of projects."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Collection
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Signal

from ilf.project.file import OpenedProject, open_project
from ilf.project.project import Project
from ilf.project.sources import Places
from ilf.sources.frame_ref import FrameRef

from ...base.paths import PROJECT_SUFFIX
from ...project.current_project import apply_settings
from ...state.entries import Entry
from ..context import Context
from .view_state import restore_views


class Opening(QObject):
    """Opens projects, and starts new ones.

    In an empty window, a folder of frames is opened with its last project, or with a new one of its own: the work on
    it is kept for the next time. In a window with frames, those of the folder are added to the list.

    Parameters
    ----------
    context : Context
    leave : callable
        Given what is about to happen, asks about work on the current project before it calls a function.

    Signals
    -------
    opened(object)
        An OpenedProject has become the current one.
    """

    opened = Signal(object)

    def __init__(self, context: Context, leave: Callable[[str, Callable[[], None]], None]) -> None:
        super().__init__(context.window)
        self._context = context
        self._present = context.recorder.present
        self.leave = leave
        self._folder: Path | None = None
        """The folder whose project the current one is."""
        context.loader.listed.connect(self._begin_of_folder)

    def open(
        self, path: Path, done: Callable[[], None] = lambda: None, fail: Callable[[], None] = lambda: None
    ) -> None:
        """Make a project the current one, then call `done`; call `fail` if it cannot be read."""

        def ask(opened: OpenedProject) -> None:
            self.leave(f"{path.name} is opened", lambda: self.begin(lambda: self._take_newest(opened, done)))

        self._context.loader.read(f"Opening {path.name}", lambda: open_project(path), ask, fail)

    def open_folder(self, how: FrameRef) -> None:
        """List the frames of a folder, with the reading options of `how`, and restore the work on them."""
        context, folder = self._context, Path(how.rgb)
        if not context.panels.persistent or len(context.workspace.entries) or self._present.path is not None:
            context.loader.open_folder(how)
            return
        home = Path(str(QSettings().value(_key(folder), "")))
        if not home.is_file():
            self._folder = folder
            context.loader.open_folder(how)
            return

        def add_new() -> None:
            self._folder = folder
            context.loader.open_folder(how, show=False)

        self.open(home, add_new, lambda: context.loader.open_folder(how))

    def begin(self, then: Callable[[], None] = lambda: None) -> None:
        """Close all frames, discard their stored states, and start an empty project; then call `then`."""
        context = self._context

        def begin() -> None:
            context.workspace.remove_entries(list(context.workspace.entries))
            context.recorder.store.set_project(None, Places())
            apply_settings(context.workspace, Project())
            self.detach()
            then()

        context.recorder.revert([entry.id for entry in context.workspace.entries], begin)

    def detach(self) -> None:
        """Make the frames those of a project without a file."""
        self._folder = None
        self._present.take(None)
        self._context.recorder.note_project()

    def is_foreign(self, place: Path) -> bool:
        """Whether a file or folder is not of the folder whose project the current one is."""
        folder = self._folder
        return folder is not None and not Path(os.path.realpath(place)).is_relative_to(os.path.realpath(folder))

    def note_saved(self, path: Path) -> None:
        """Store the file of the saved project: its folder is opened with it from now on."""
        if self._folder is not None:
            QSettings().setValue(_key(self._folder), str(path))

    def take(
        self,
        project: Project,
        places: Places,
        opened: OpenedProject | None,
        unsaved: Collection[str] = (),
        read_only: str = "",
    ) -> None:
        """Make a project the current one, in a window without frames.

        Parameters
        ----------
        project : Project
        places : Places
            Places of the files of its frames.
        opened : OpenedProject or None
            Its file, which may not contain all of the work; None if it has none.
        unsaved : collection of str
            Ids of the frames with work that is not in the file, but stored in this window.
        read_only : str
            Why the file must not be replaced; "" if it may be.
        """
        present = self._present
        self._context.recorder.store.set_project(None if opened is None else opened.parts, places)
        apply_settings(self._context.workspace, project)
        entries = []
        for frame in project.frames:
            key = frame.id if frame.source is None else frame.source.key
            entries.append(Entry(frame.id, key, frame.name, frame.source, has_state=frame.has_state))
            entries[-1].set_summary(frame.summary)
            entries[-1].set_unsaved(frame.id in unsaved)
        self._context.workspace.add_entries(entries)
        if opened is None:
            present.take(None)
        else:
            present.take(opened.path, opened.project, read_only)
        restore_views(self._context.views, project.view)
        first = self._context.workspace.entries.of(project.present) or next(iter(entries), None)
        if first is not None:
            self._context.loader.open_entry(first)
        self._context.recorder.note_project()

    def _take_newest(self, opened: OpenedProject, done: Callable[[], None]) -> None:
        """Make a project the current one; read it again if it was saved meanwhile, as when it was the current one."""

        def take(opened: OpenedProject) -> None:
            self.take(opened.project, opened.places, opened)
            beside = opened.path.with_suffix("")
            self._folder = beside if beside.is_dir() else None
            self.opened.emit(opened)
            done()

        if not opened.parts.replaced():
            take(opened)
            return
        opened.close()
        self._context.loader.read(f"Opening {opened.path.name}", lambda: open_project(opened.path), take)

    def _begin_of_folder(self, how: FrameRef) -> None:
        """Start the folder's own project for its listed frames, without a question."""
        if self._folder != Path(how.rgb):
            return
        if self._present.path is not None:
            self._present.mark_saved("frames")
            return
        beside = _beside(self._folder)
        if beside.exists():
            text = f"{beside} may be a project of this folder: open it to continue the work in it."
            self._context.notes.show_message(text)
        elif all(os.access(place, os.W_OK) for place in (self._folder, self._folder.parent)):
            self._present.take(beside)


def _beside(folder: Path) -> Path:
    """Return where a new project of a folder is saved."""
    place = os.path.realpath(folder)
    return folder.parent / f"{os.path.basename(place) or 'frames'}{PROJECT_SUFFIX}"


def _key(folder: Path) -> str:
    """Return the setting with the project of a folder."""
    return f"folders/{hashlib.sha256(os.fsencode(os.path.realpath(folder))).hexdigest()[:16]}"
