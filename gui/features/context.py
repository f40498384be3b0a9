"""Context that the features of the window share, and the base class of features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMainWindow

from ..base.commands import Actions
from ..base.needs import NOTHING, Need, sentence
from ..project.recorder import Recorder
from ..state.document import Document
from ..state.workspace import Workspace
from ..tools.editor import Editor
from ..views.centre import Centre
from ..views.cloud.cloud_view import CloudView
from ..views.linked_views import LinkedViews
from ..widgets.docks import Docks
from ..widgets.notices import Notes
from ..work.loading import FrameLoader
from ..work.refresh import Refresh
from ..work.runs import RunController


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
    document: Document | None = None


class Reasons:
    """Why commands cannot be used now: the sentences that several commands share; "" if nothing is missing."""

    def __init__(self, workspace: Workspace, runs: RunController, loader: FrameLoader) -> None:
        self._workspace = workspace
        self._runs = runs
        self._loader = loader
        self._missing = Need.UNLOCKED
        self.selected: set[int] = set()
        """The selected blocks that have pixels."""
        self.unlocked: set[int] = set()
        """Those of them that are not locked."""
        self.playing = False
        """Whether the frames are played: none is open meanwhile."""

    def missing(self) -> Need:
        """Return what is missing now of all that commands may need."""
        document = self._workspace.current if self._workspace.has_current else None
        counts = document.counts() if document else {}
        self.selected = set(document.selected) & counts.keys() if document else set()
        self.unlocked = self.selected - document.locked if document else set()
        there = NOTHING if self.playing else Need.NOT_PLAYING
        if self._runs.free and not self._loader.busy:
            there |= Need.IDLE
        for need, given in (
            (Need.FRAME, document),
            (Need.BLOCKS, counts),
            (Need.SELECTION, self.selected),
            (Need.UNLOCKED, self.unlocked),
        ):
            if given:
                there |= need
        self._missing = ~there
        return self._missing

    def no_frame(self) -> str:
        """No frame is shown."""
        return sentence(Need.FRAME & self._missing)

    def busy(self) -> str:
        """The frame is being read, extracted or run."""
        return sentence((Need.FRAME | Need.IDLE) & self._missing)

    def no_blocks(self) -> str:
        """The frame has no blocks."""
        return sentence(Need.BLOCKS & self._missing)

    def none_selected(self) -> str:
        """No block is selected."""
        return sentence(Need.SELECTION & self._missing)


FeatureType = TypeVar("FeatureType", bound="Feature")


@dataclass(frozen=True, eq=False, kw_only=True)
class Context:
    """Shared objects of the window: what a feature may use.

    Attributes
    ----------
    window : QMainWindow
        Parent of dialogs, with menu bar and status bar.
    workspace, recorder
        The data, and what stores it.
    loader, runs, refresh
        The work: reading of frames, runs, and drawing of what has become stale.
    editor
        Host of the tools.
    views, cloud, centre, panels, notes
        The display: linked views, point cloud, the centre with both, the panels around it, and messages.
    actions, reasons
        The commands, and why they cannot be used.
    features : list of Feature
        All features, in the order in which they were made.
    """

    window: QMainWindow
    workspace: Workspace
    recorder: Recorder
    loader: FrameLoader
    runs: RunController
    refresh: Refresh
    editor: Editor
    views: LinkedViews
    cloud: CloudView
    centre: Centre
    panels: Docks
    notes: Notes
    actions: Actions
    reasons: Reasons
    features: list[Feature] = field(default_factory=list)

    def feature(self, kind: type[FeatureType]) -> FeatureType:
        """Return the feature of a type; it is made now if nothing has used it yet."""
        made = next((feature for feature in self.features if isinstance(feature, kind)), None)
        return kind(self) if made is None else made

    def pending_work(self) -> list[PendingWork]:
        """Return the pending work of all features, without the runs of frames."""
        return [work for feature in self.features for work in feature.pending_work()]


class Feature(QObject):
    """One feature of the window with all that belongs to it.

    When it is made, a feature adds its commands to the context's actions, makes its widgets, adds its panels to the
    context's docks, registers their updates with the context's refresh, and passes its messages to the context's
    notes.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self.context = context
        context.features.append(self)

    def begin(self) -> None:
        """Called when the window has all features and menus, just before it is shown; not for one made on use."""

    def pending_work(self) -> Sequence[PendingWork]:
        """Pending background work that would be lost."""
        return ()

    def shutdown(self) -> bool:
        """Stop what is not a `Worker`: the window stops these, and closes the dialogs, before it closes. True if no
        thread is left."""
        return True
