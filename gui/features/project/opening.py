"""Opening of projects."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Signal

from ilf.project.file import OpenedProject, open_project
from ilf.project.project import Project
from ilf.project.sources import Places
from ilf.sources.frame_ref import FrameRef

from ...base.paths import PROJECT_SUFFIX
from ...project.current_project import apply_settings
from ...state.workspace import Entry
from ...work.steps import Steps, in_steps
from ..context import Context
from ..layouts import restore_views


class Opening(QObject):
    """Opens projects, and starts new ones.

    In an empty window, a folder of frames is opened with its last project, or with a new one of its own: the work on
    it is kept for the next time. In a window with frames, those of the folder are added to the list.

    Parameters
    ----------
    context : Context
    left : callable
        Given what is about to happen, returns the steps that ask about work on the current project, and return whether
        to go on.

    Signals
    -------
    opened(object)
        An OpenedProject has become the current one.
    """

    opened = Signal(object)

    def __init__(self, context: Context, left: Callable[[str], Steps[bool]]) -> None:
        super().__init__(context.window)
        self._context = context
        self.left = left
        self._folder: Path | None = None
        """The folder whose project the current one is."""
        context.loader.listed.connect(self._begin_of_folder)

    @in_steps
    def open(self, path: Path) -> Steps[None]:
        """Make a project the current one, after asking about the present one."""
        opened = yield from self._read(path)
        if opened is not None:
            yield from self._take_newest(opened)

    @in_steps
    def open_folder(self, how: FrameRef) -> Steps[None]:
        """List the frames of a folder, with the reading options of `how`, and restore the work on them."""
        context, folder = self._context, Path(how.rgb)
        if not context.persistent or len(context.workspace.entries) or context.recorder.present.path is not None:
            context.loader.open_folder(how)
            return
        home = Path(str(QSettings().value(_key(folder), "")))
        if not home.is_file():
            self._folder = folder
            context.loader.open_folder(how)
            return
        opened = yield from self._read(home)
        if opened is None:
            context.loader.open_folder(how)
        elif (yield from self._take_newest(opened)):
            self._folder = folder
            context.loader.open_folder(how, show=False)

    def _read(self, path: Path) -> Steps[OpenedProject | None]:
        """Read a project file; None, with a message, if it cannot be read."""
        read = partial(self._context.loader.read, f"Opening {path.name}", partial(open_project, path))
        opened: OpenedProject | None = yield lambda go: read(go, go)
        return opened

    def begin(self) -> Steps[None]:
        """Close all frames, discard their stored states, and start an empty project."""
        context = self._context
        yield partial(context.recorder.revert, [entry.id for entry in context.workspace.entries])
        context.workspace.remove_entries(list(context.workspace.entries))
        context.recorder.store.set_project(None, Places())
        apply_settings(context.workspace, Project())
        self.detach()

    def detach(self) -> None:
        """Make the frames those of a project without a file."""
        self._folder = None
        self._context.recorder.present.take(None)
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
        present = self._context.recorder.present
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

    def _take_newest(self, opened: OpenedProject) -> Steps[bool]:
        """Make a project the current one, if the user leaves the present one; read it again if it was saved meanwhile,
        as when it was the current one. Return whether that was done."""
        path = opened.path
        if not (yield from self.left(f"{path.name} is opened")):
            return False
        yield from self.begin()
        newest: OpenedProject | None = opened
        if opened.parts.replaced():
            opened.close()
            newest = yield from self._read(path)
        if newest is None:
            return False
        self.take(newest.project, newest.places, newest)
        beside = path.with_suffix("")
        self._folder = beside if beside.is_dir() else None
        self.opened.emit(newest)
        return True

    def _begin_of_folder(self, how: FrameRef) -> None:
        """Start the folder's own project for its listed frames, without a question."""
        if self._folder != Path(how.rgb):
            return
        if self._context.recorder.present.path is not None:
            self._context.recorder.present.mark_listed()
            return
        beside = _beside(self._folder)
        if beside.exists():
            text = f"{beside} may be a project of this folder: open it to continue the work in it."
            self._context.notes.show_message(text)
        elif all(os.access(place, os.W_OK) for place in (self._folder, self._folder.parent)):
            self._context.recorder.present.take(beside)


def _beside(folder: Path) -> Path:
    """Return where a new project of a folder is saved."""
    place = os.path.realpath(folder)
    return folder.parent / f"{os.path.basename(place) or 'frames'}{PROJECT_SUFFIX}"


def _key(folder: Path) -> str:
    """Return the setting with the project of a folder."""
    return f"folders/{hashlib.sha256(os.fsencode(os.path.realpath(folder))).hexdigest()[:16]}"
