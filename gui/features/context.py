"""Context that the features of the window share, and the base class of features."""

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
from ..views.expected_error import ErrorPresenter
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


class PendingWork(NamedTuple):
    """Pending background work, whose result is lost if its frame is closed.

    Attributes
    ----------
    what : str
        Description, such as "a sweep of Threshold".
    session : Session or None
        The frame of the work; None for none.
    """

    what: str
    session: Session | None = None


@dataclass(frozen=True, eq=False)
class Context:
    """Shared objects of the window: data, workers and widgets that a feature may use."""

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
    pending_work: Callable[[], Sequence[PendingWork]]
    """Returns the pending work of all features, without the runs of frames."""
    selected_frames: Callable[[], Sequence[Entry]]
    """Returns the frames whose rows are selected in the list."""


class Feature(QObject):
    """One feature of the window with all that belongs to it.

    A feature creates its widgets, adds its panels to the context's docks, registers their updates with the context's
    refresh, and executes its own commands.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self.context = context

    def begin(self) -> None:
        """Called when the window has all features and menus, just before it is shown."""

    def pending_work(self) -> Sequence[PendingWork]:
        """Pending background work that would be lost."""
        return ()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if no thread of the feature is left."""
        return True
