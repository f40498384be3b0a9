"""Folders of frames that are opened without a project: the work on them is kept, and there again the next time."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, QSettings

from gui.desk import Desk
from gui.project_file.present import PresentProject
from ilf.io.frame_source import FrameSource
from ilf.project.file import OpenedProject
from ilf.project.folder_files import project_of_folder, projects_of_folders


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
