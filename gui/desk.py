"""What the parts of the window share, and what a part is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMainWindow

from gui.actions import Actions
from gui.centre import Centre
from gui.cloud.cloud_view import CloudView
from gui.dialogs.documents import Documents
from gui.docks import Docks
from gui.filtering.filter_panel import FilterPanel
from gui.filtering.presenter import FilterPresenter
from gui.frames.loader import FrameLoader
from gui.project.recorder import Recorder
from gui.project.store import WorkStore
from gui.state.entries import Entry
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.tools.editor import Editor
from gui.views.errors import ErrorPresenter
from gui.views.linked_views import LinkedViews
from gui.views.presenter import ViewsPresenter
from gui.widgets.notes import Notes
from gui.work.refresh import Refresh
from gui.work.runs import RunController


class UnderWay(NamedTuple):
    """Work in the background whose outcome is lost with what it is about.

    Attributes
    ----------
    what : str
        As in "a sweep of Threshold".
    session : Session or None
        The frame that it is about; None if it is about none.
    """

    what: str
    session: Session | None = None


@dataclass(frozen=True, eq=False)
class Desk:
    """What is worked on, what works, and where it is shown: all that a part of the window may need of the others."""

    window: QMainWindow
    workspace: Workspace
    runs: RunController
    loader: FrameLoader
    views: LinkedViews
    cloud: CloudView
    view_presenter: ViewsPresenter
    editor: Editor
    actions: Actions
    panels: Docks
    refresh: Refresh
    notes: Notes
    filter_panel: FilterPanel
    filter_presenter: FilterPresenter
    errors: ErrorPresenter
    documents: Documents
    centre: Centre
    store: WorkStore
    recorder: Recorder
    under_way: Callable[[], Sequence[UnderWay]]
    """What all parts have under way, runs of frames aside."""
    chosen_frames: Callable[[], Sequence[Entry]]
    """The frames whose rows are chosen in the list."""


class Part(QObject):
    """One thing that a user does, with all that belongs to it.

    It makes its widgets, adds its panels to the desk's, has them brought up to date by the desk's refresh, and carries
    its own commands out.
    """

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk.window)
        self.desk = desk

    def begin(self) -> None:
        """The window has all its parts and menus, and is about to be shown."""

    def under_way(self) -> Sequence[UnderWay]:
        """What it does in the background, and would be lost."""
        return ()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread of it is left."""
        return True
