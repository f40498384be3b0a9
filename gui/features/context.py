"""What the parts of the window share, and what a part is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMainWindow

from ..base.actions import Actions
from ..project.recorder import Recorder
from ..project.store import WorkStore
from ..state.entries import Entry
from ..state.session import Session
from ..state.workspace import Workspace
from ..tools.editor import Editor
from ..views.centre import Centre
from ..views.cloud.cloud_view import CloudView
from ..views.errors import ErrorPresenter
from ..views.linked_views import LinkedViews
from ..views.presenter import ViewsPresenter
from ..widgets.docks import Docks
from ..widgets.notices import Notes
from ..work.loading import FrameLoader
from ..work.refresh import Refresh
from ..work.runs import RunController
from .documents.documents import Documents
from .filter.panel import FilterPanel
from .filter.presenter import FilterPresenter


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
