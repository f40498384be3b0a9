"""Context that the features of the window share, and the base class of features."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, TypeVar

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMainWindow

from ilf.project.recovery import autosave_folder

from ..base.commands import Actions, Command, commands_of
from ..base.needs import NOTHING, Need
from ..project.loading import FrameLoader
from ..project.recorder import Recorder
from ..project.store import WorkStore
from ..state.parts import Part
from ..state.workspace import Workspace
from ..tools.editor import Editor
from ..views.centre import Centre
from ..views.linked_views import LinkedViews
from ..widgets.docks import Docks
from ..widgets.notes import Notes
from ..widgets.notices import LogPanel
from ..work.frame_runs import RunController
from ..work.latest_request import Job, LatestRequest
from ..work.refresh import Refresh

_OF_COMMANDS = ~(Part.STROKE | Part.CONTENT | Part.RECORDS | Part.PREVIEWS)
"""The parts on which it depends whether a command can be used."""

_OF_FRAME = ~Need.NOT_PLAYING
"""What a frame gives, whether or not frames are played."""

FeatureType = TypeVar("FeatureType", bound="Feature")


class Context:
    """Shared objects of the window: what a feature may use.

    Parameters
    ----------
    window : QMainWindow
        Parent of dialogs, with menu bar and status bar.
    persistent : bool
        Whether work is saved automatically, and restored.

    Attributes
    ----------
    workspace, recorder
        The data, and what stores it.
    loader, runs, refresh
        The work: reading of frames, runs, and drawing of what has become stale.
    panels, views, centre, log, notes
        The display: the panels around the centre, linked views, the centre with them and the point cloud, and messages.
    editor
        Host of the tools.
    actions
        The commands.
    features : list of Feature
        Those that are made, in that order.
    """

    def __init__(self, window: QMainWindow, persistent: bool) -> None:
        self.window, self.persistent = window, persistent
        self.workspace = workspace = Workspace(window)
        self.recorder = Recorder(workspace, WorkStore(autosave_folder() if persistent else None), window)
        self.runs = RunController(workspace, window)
        self.runs.state_changed.connect(lambda: workspace.note(Part.RUNNING))
        self.refresh = Refresh(workspace, window)
        self.panels = Docks(window)
        self.views = LinkedViews(workspace)
        self.centre = Centre(self.views)
        self.log = LogPanel()
        self.notes = Notes(window, self.log)
        self.loader = FrameLoader(workspace, self.recorder.store, self.notes, window)
        self.loader.busy_changed.connect(lambda: workspace.note(Part.LOADING))
        self.editor = Editor(workspace, self.views, window)
        self.actions = Actions(window, self.missing)
        self.features: list[Feature] = []
        self._kinds: list[type[Feature]] = []
        self.refresh.add("commands", self.actions.refresh, _OF_COMMANDS, also=(self.editor.tool_changed,))
        shown = self.views.shownChanged, self.centre.turned
        self.refresh.add("features", self._make_awaited, _OF_COMMANDS, also=shown)

    def add(self, kind: type[Feature]) -> None:
        """Add a type of feature: its commands are there, and its panel; it is made when it is first used."""
        self._kinds.append(kind)
        kind.declare(self)
        if kind.at_start:
            self.feature(kind)

    def made(self, kind: type[FeatureType]) -> FeatureType | None:
        """Return the feature of a type; None if nothing has used it yet."""
        return next((feature for feature in self.features if isinstance(feature, kind)), None)

    def feature(self, kind: type[FeatureType]) -> FeatureType:
        """Return the feature of a type; it is made now if nothing has used it yet."""
        if kind not in self._kinds:
            self.add(kind)
        return self.made(kind) or kind(self)

    def _make_awaited(self) -> None:
        """Make the features whose contents a view shows, or for which there is what they await."""
        missing = self.missing()
        for kind in self._kinds:
            awaited = kind.awaits and not kind.awaits & missing
            if (awaited or any(map(self.views.shows, kind.contents))) and self.made(kind) is None:
                kind(self)

    def missing(self) -> Need:
        """Return what is missing now of all that commands may need."""
        workspace = self.workspace
        document = workspace.shown
        there = NOTHING if self.actions.is_on("play_frames") else Need.NOT_PLAYING
        prepared = not self.loader.reading and document not in self.loader.extracting
        there |= Need.IDLE if self.runs.state.free and prepared else NOTHING
        there |= Need.GOING if self.runs.state.going else NOTHING
        for need, count in ((Need.LISTED, 1), (Need.OTHERS, 2)):
            there |= need if len(workspace.entries) >= count else NOTHING
        if document is None:
            return ~there
        frame, blocks = document.frame, document.counts().keys()
        chosen = blocks & set(document.selected)
        free = chosen - document.locked
        for need, given in (
            (Need.FRAME, True),
            (Need.BLOCKS, blocks),
            (Need.SELECTION, chosen),
            (Need.UNLOCKED, free),
            (Need.SEVERAL, len(free) > 1),
            (Need.RESULTS, document.results.kept),
            (Need.RUNS, document.state.runs),
            (Need.GROUND_TRUTH, frame.ground_truth is not None),
            (Need.GUIDE, frame.guide is not None),
            (Need.NEIGHBOURS, frame.neighbours is not None),
            (Need.BY_HAND, document.blocks.by_hand is not None),
        ):
            if given:
                there |= need & _OF_FRAME
        return ~there

    def pending_work(self) -> list[Job]:
        """Return the pending work of all features, without the runs of frames: what it is, and about which frame."""
        return [work for feature in self.features for work in feature.pending_work()]


class Feature(QObject):
    """One feature of the window with all that belongs to it.

    Its commands are there from the start. It is made when one of them is first used, its panel is shown, or another
    feature asks for it. Then it makes its widgets, registers their updates with the context's refresh, and passes its
    messages to the context's notes. What takes time it asks for by `requests.ask`: the answer is found in a worker
    thread, from a copy of what changes in place, as the label map does.

    Attributes
    ----------
    context : Context
    workspace, notes, views
        Those of the context.
    what : str
        What is computed, as in "hold-out test": named in errors.
    more_commands : sequence of Command
        Commands beside its methods; their handlers are given the feature.
    at_start : bool
        Whether it is made with the window, since it listens from then on.
    awaits : Need
        It is made as soon as this is there.
    contents : tuple of str
        What it finds for the views, as in "edges": it is made when a view shows one of these.
    """

    what: ClassVar[str] = "computation"
    more_commands: ClassVar[Sequence[Command]] = ()
    at_start: ClassVar[bool] = False
    awaits: ClassVar[Need] = NOTHING
    contents: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def declare(cls, context: Context) -> None:
        """Add what there is of it before it is made."""
        context.actions.add(commands_of(cls, lambda: context.feature(cls)))

    def __init__(self, context: Context) -> None:
        super().__init__(context.window)
        self.context = context
        self.workspace, self.notes, self.views = context.workspace, context.notes, context.views
        context.features.append(self)

    @cached_property
    def requests(self) -> LatestRequest:
        """What it asks for; errors go to `fail`."""
        return LatestRequest(self, self.fail)

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self.requests.busy

    def fail(self, error: Exception) -> None:
        """Handle an error of what was asked for."""
        self.notes.report(f"The {self.what} failed", error)

    def pending_work(self) -> Sequence[Job]:
        """What is asked for and would be lost if its frame or the window were closed: that of which is said `what` it
        is."""
        job = self.requests.question if "requests" in vars(self) else None
        return [job] if job is not None and job.what else []

    def shutdown(self) -> None:
        """Called before the window closes, when its workers have been stopped and its dialogs are still open."""
