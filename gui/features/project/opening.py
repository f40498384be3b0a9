"""Taking up a project in the place of the present one."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Signal

from ilf.project.archive import Archive
from ilf.project.file import OpenedProject, open_project
from ilf.project.finding import project_of_folder, projects_of_folders
from ilf.project.project import Project, ProjectFrame
from ilf.project.sources import Places
from ilf.sources.frame_source import FrameSource

from ...project.present import PresentProject, Set, take_settings
from ...state.entries import Entry
from ..context import Desk
from .view_state import ViewState


class Opening(QObject):
    """Opens projects, and begins new ones. What becomes of the present one has been asked before.

    Signals
    -------
    opened(object)
        An OpenedProject is the present one now.
    """

    opened = Signal(object)

    def __init__(self, desk: Desk, present: PresentProject, view: ViewState) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._present = present
        self._view = view

    def open(self, path: Path, then: Callable[[Callable[[], None]], None]) -> None:
        """Read a project file; once it is known to be one, `then` is given what takes it up."""
        read = self._desk.loader.read
        read(
            f"Open {path.name}",
            lambda: open_project(path),
            lambda opened: then(lambda: self._leave(lambda: self._take_newest(opened))),
        )

    def begin(self) -> None:
        """A new project, without frames."""
        self._leave(self._begin)

    def _begin(self) -> None:
        take_settings(self._desk.workspace, Project())
        self._present.take(None)
        self._record("")

    def _leave(self, then: Callable[[], None]) -> None:
        """Close all frames of the present project, with what is stored of them; what follows comes afterwards."""
        desk = self._desk

        def leave() -> None:
            desk.workspace.remove_entries(list(desk.workspace.entries))
            former, desk.store.project, desk.store.places = desk.store.project, None, Places()
            if isinstance(former, Archive):
                former.close()
            then()

        desk.recorder.revert([entry.id for entry in desk.workspace.entries], leave)

    def take_back(
        self,
        project: Project,
        places: Places,
        opened: OpenedProject | None,
        unsaved: Collection[str],
        read_only: str = "",
    ) -> None:
        """Go on with a project that another window has left behind, in a window without frames.

        Parameters
        ----------
        project : Project
        places : Places
            Where the files of its frames are.
        opened : OpenedProject or None
            Its file, which does not hold all of it; None if it has none.
        unsaved : collection of str
            Ids of the frames with work that is not in the file, but stored by now.
        read_only : str
            Why the file must not be replaced; "" if nothing is known against that.
        """
        store, present = self._desk.store, self._present
        store.project, store.places = None if opened is None else opened.parts, places
        self._fill(project, unsaved)
        if opened is None:
            present.take(None)
        else:
            why = _why_not_written(opened.path) or read_only
            present.take(opened.path, opened.project, why, Set.of(opened.project))
        self._show(project)
        self._record("" if opened is None else str(opened.path))

    def _take_newest(self, opened: OpenedProject) -> None:
        """Take up a project; it is read again if it has been saved meanwhile, as when it is the one that was left."""
        if not opened.parts.replaced():
            self._take(opened)
            return
        opened.close()
        self._begin()
        self._desk.loader.read(f"Open {opened.path.name}", lambda: open_project(opened.path), self._take)

    def _take(self, opened: OpenedProject) -> None:
        store = self._desk.store
        store.project, store.places = opened.parts, opened.places
        self._fill(opened.project)
        self._present.take(opened.path, opened.project, _why_not_written(opened.path))
        self._show(opened.project)
        self._record(str(opened.path))
        self.opened.emit(opened)

    def _fill(self, project: Project, unsaved: Collection[str] = ()) -> None:
        """List the frames of a project, and set what is set for all of them."""
        take_settings(self._desk.workspace, project)
        self._desk.workspace.add_entries([entry_of(frame, frame.id in unsaved) for frame in project.frames])

    def _show(self, project: Project) -> None:
        """Show it as it was looked at last."""
        self._view.take(project.view)
        entries = self._desk.workspace.entries
        first = entries.of(project.present) or next(iter(entries), None)
        if first is not None:
            self._desk.loader.open_entry(first)

    def _record(self, path: str) -> None:
        self._desk.recorder.project = path
        self._desk.recorder.note_project()


def entry_of(frame: ProjectFrame, unsaved: bool = False) -> Entry:
    """The entry of a project's frame, with work that the file does not hold or without."""
    key = frame.id if frame.source is None else frame.source.key
    entry = Entry(frame.id, key, frame.name, frame.source, has_state=frame.has_state)
    entry.set_summary(frame.summary)
    entry.set_unsaved(unsaved)
    return entry


def _why_not_written(path: Path) -> str:
    """Why a project file cannot be replaced; "" if nothing is known against it."""
    if not os.access(path, os.W_OK):
        return f"{path.name} is write-protected: it can be looked at and worked on, and Save asks for another place."
    if not os.access(path.parent, os.W_OK):
        return f"{path.parent} cannot be written: the project can be worked on, and Save asks for another place."
    return ""


# Folders of frames that are opened without a project: the work on them is kept, and there again the next time.


class FolderProjects(QObject):
    """Gives a folder that is opened in an empty window the project that it had the last time, or one of its own.

    Into a window that has frames already, its frames just come to the others.

    Parameters
    ----------
    desk : Desk
    present : PresentProject
    open_project : callable
        Opens a project file.
    """

    def __init__(self, desk: Desk, present: PresentProject, open_project: Callable[[Path], None]) -> None:
        super().__init__(desk.window)
        self._desk = desk
        self._present = present
        self._open_project = open_project
        self._folder: Path | None = None
        """The one that the present project was begun with."""
        self._coming: tuple[Path, FrameSource] | None = None
        """The project that is being opened for a folder, and how the folder is read."""
        desk.documents.folder_wished.connect(self.open)
        desk.loader.listed.connect(self._begin)
        desk.loader.failed.connect(self._open_without)

    def open(self, how: FrameSource) -> None:
        """List the frames of a folder, read with the units and intrinsics of `how`, with the work on them."""
        desk, folder = self._desk, Path(how.rgb)
        if not desk.panels.remembers or len(desk.workspace.entries) or self._present.path is not None:
            desk.loader.open_folder(how)
            return
        self._folder = folder
        home = self._home(folder)
        if home.is_file():
            self._coming = home, how
            self._open_project(home)
        else:
            desk.loader.open_folder(how)

    def proposed(self) -> Path | None:
        """The project's file, if it is not one that the user has never seen."""
        path = self._present.path
        return None if path is None or path.is_relative_to(projects_of_folders()) else path

    def note_opened(self, opened: OpenedProject) -> None:
        """A project has been opened: if it is that of a folder, frames that have come there since are added."""
        coming, self._coming = self._coming, None
        if coming is None or coming[0] != opened.path:
            self._folder = None
        else:
            self._desk.loader.open_folder(coming[1], show=False)

    def forget(self) -> None:
        """Another project begins, which is of no folder."""
        self._folder = self._coming = None

    def note_saved(self, path: Path) -> None:
        """The project has been saved: its folder is opened with this file from now on."""
        if self._folder is not None:
            QSettings().setValue(_key(self._folder), str(path))

    def _home(self, folder: Path) -> Path:
        """The file that the folder's project was saved to last, or one in the user's data folder."""
        saved = str(QSettings().value(_key(folder), ""))
        return Path(saved) if os.path.isfile(saved) else project_of_folder(folder)

    def _begin(self, how: FrameSource) -> None:
        """The frames of a folder are there: the work on them goes into its own project, without a question."""
        if self._folder != Path(how.rgb):
            return
        if self._present.path is None:
            self._present.take(project_of_folder(how.rgb), new=True)
        else:
            self._present.take_frames()

    def _open_without(self, what: str, error: Exception) -> None:
        """If the folder's project cannot be opened, its frames can; the file is left as it is."""
        if self._coming is not None:
            how = self._coming[1]
            self.forget()
            self._desk.loader.open_folder(how)


def _key(folder: Path) -> str:
    return f"folders/{project_of_folder(folder).parent.name}"
