"""Taking up a project in the place of the present one."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from gui.desk import Desk
from gui.project.whole import take_settings
from gui.project_file.present import PresentProject
from gui.project_file.view_state import ViewState
from gui.state.entries import Entry
from ilf.project import Project, ProjectFrame
from ilf.project.file import OpenedProject, open_project
from ilf.project.sources import Places


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
            lambda opened: then(lambda: self._leave(lambda: self._take(opened))),
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
            desk.store.project, desk.store.places = None, Places()
            then()

        desk.recorder.revert([entry.id for entry in desk.workspace.entries], leave)

    def _take(self, opened: OpenedProject) -> None:
        desk, project = self._desk, opened.project
        workspace = desk.workspace
        desk.store.project, desk.store.places = opened.parts, opened.places
        take_settings(workspace, project)
        workspace.add_entries([_entry(frame) for frame in project.frames])
        self._present.take(opened.path, project, opened.read_only or _why_not_written(opened.path))
        self._view.take(project.view)
        first = workspace.entries.of(project.present) or next(iter(workspace.entries), None)
        if first is not None:
            desk.loader.open_entry(first)
        self._record(str(opened.path))
        self.opened.emit(opened)

    def _record(self, path: str) -> None:
        self._desk.recorder.project = path
        self._desk.recorder.note_project()


def _entry(frame: ProjectFrame) -> Entry:
    key = frame.id if frame.source is None else frame.source.key
    entry = Entry(frame.id, key, frame.name, frame.source, has_state=frame.has_state)
    entry.set_summary(frame.summary)
    return entry


def _why_not_written(path: Path) -> str:
    """Why a project file cannot be replaced; "" if nothing is known against it."""
    if not os.access(path, os.W_OK):
        return f"{path.name} is write-protected: it can be looked at and worked on, and Save asks for another place."
    if not os.access(path.parent, os.W_OK):
        return f"{path.parent} cannot be written: the project can be worked on, and Save asks for another place."
    return ""
