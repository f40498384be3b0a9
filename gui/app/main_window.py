"""The main window: state, controllers, widgets, presenters and the connections between them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from PySide6.QtCore import QEvent, QSignalBlocker, Qt
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDragLeaveEvent, QDropEvent, QPixmap, QShowEvent, QUndoGroup
from PySide6.QtWidgets import QMainWindow, QTabWidget, QUndoView, QWidget

from ilf._runtime.formatting import counted
from ilf.drawing.blocks import STAGES
from ilf.project.recovery import journal_folder

from ..base.actions import Actions
from ..features.accuracy.feature import AccuracyFeature
from ..features.batch.feature import BatchFeature
from ..features.blocks.presenter import BlocksPresenter
from ..features.blocks.table import BlockTable
from ..features.cloud import CloudPresenter
from ..features.colour_range import ColourRangeFeature
from ..features.compare import CompareFeature
from ..features.context import Context, Feature, PendingWork
from ..features.documents.documents import Documents
from ..features.documents.replays import ReplayPresenter
from ..features.edit_summary import EditSummaryLine, EditSummaryPresenter
from ..features.experiments.menu import ExperimentsMenu
from ..features.extraction import ExtractionPanel, StagePresenter
from ..features.filter.panel import FilterPanel
from ..features.filter.presenter import FilterPresenter
from ..features.filter.sharing import SharingPresenter
from ..features.frame_list.feature import FramesFeature
from ..features.frame_list.panel import FramesPanel
from ..features.guide import GuideFeature
from ..features.inspect.feature import InspectFeature
from ..features.layouts.feature import LayoutsFeature
from ..features.menus import BLOCK_MENU, ToolBar, entries, fill_menu_bar
from ..features.palette.palette import PaletteFeature
from ..features.presets import PresetsFeature
from ..features.project.autosave import AutosaveFeature
from ..features.project.feature import ProjectFeature
from ..features.project.recent import RecentFeature
from ..features.propagation.feature import PropagationFeature
from ..features.quality_check.invalid_depth import InvalidDepthPresenter
from ..features.quality_check.marks import ReviewStrip
from ..features.quality_check.presenter import ReviewPresenter
from ..features.report.feature import ReportFeature
from ..features.run_history.feature import RunHistoryFeature
from ..features.shortcuts import ShortcutsFeature
from ..features.status import CommandsPresenter, ReadoutPresenter, StatusBar, StatusPresenter
from ..features.sweep.feature import SweepFeature
from ..project.recorder import Recorder
from ..project.store import WorkStore
from ..state.workspace import Workspace
from ..tools.block_commands import BlockCommands, ContextMenu
from ..tools.editor import Editor
from ..tools.keys import ToolKeys
from ..tools.presenter import ToolsPresenter
from ..views.centre import Centre
from ..views.cloud.canvas import HINT, MOVES
from ..views.cloud.cloud_view import CloudView
from ..views.curves.panel import CurvesPanel
from ..views.curves.presenter import CurvesPresenter, ScrubPresenter
from ..views.expected_error import ErrorPresenter
from ..views.interaction import PointerEvent
from ..views.linked_views import LinkedViews
from ..views.presenter import ViewsPresenter
from ..views.view_menus import ViewBar
from ..widgets.docks import Docks
from ..widgets.notices import LogPanel, Notes, Toasts
from ..work.frame_runs import RunState
from ..work.loading import FrameLoader
from ..work.refresh import Refresh
from ..work.runs import LiveSolver, RunController
from .about import AboutDialog
from .drops import FileDrops

# The undo history of the current frame.


class HistoryView(QUndoView):
    """The list of the frame's undo steps, oldest first, with the current state marked."""

    def __init__(self, history: QUndoGroup, parent: QWidget | None = None) -> None:
        super().__init__(history, parent)
        self.setEmptyLabel("As opened")
        self.setAccessibleName("History")
        self.setToolTip("Click a step to go to the state after it")
        self.setUniformItemSizes(True)


_PARTS: tuple[type[Feature], ...] = (
    RunHistoryFeature,
    PropagationFeature,
    PresetsFeature,
    SweepFeature,
    AccuracyFeature,
    GuideFeature,
    InspectFeature,
    CompareFeature,
    ColourRangeFeature,
    RecentFeature,
    ReportFeature,
    BatchFeature,
    LayoutsFeature,
    ShortcutsFeature,
    PaletteFeature,
)


class MainWindow(QMainWindow):
    """The main window. It only connects workspace (state), controllers (work), presenters and widgets.

    With `persistent`, size and panels are restored from the last session and stored for the next, and work is saved
    automatically.
    """

    def __init__(self, persistent: bool = True) -> None:
        super().__init__()
        self._make_state(persistent)
        self.panels = Docks(self, self.actions_["toggle_panels"], persistent)
        self._make_widgets()
        self._make_presenters()
        self._make_layout()
        self._connect_refresh()
        self._make_parts()
        self._connect_commands()
        self._connect_messages()
        for part in self.parts:
            part.begin()
        self.commands.show()
        self.refresh.draw_all()
        self.panels.size_window()

    def _make_state(self, persistent: bool) -> None:
        self.workspace = Workspace(self)
        self.store = WorkStore(journal_folder() if persistent else None)
        self.recorder = Recorder(self.workspace, self.store, self)
        self.loader = FrameLoader(self.workspace, self)
        self.runs = RunController(self.workspace, self)
        self.refresh = Refresh(self)
        self.actions_ = Actions(self, self.workspace.undo_group)

    def _make_widgets(self) -> None:
        actions = self.actions_
        self.status = StatusBar()
        self.log = LogPanel()
        self.views = LinkedViews()
        self.edit_summary_line = EditSummaryLine()
        going = [actions[name] for name in ["previous_check", "next_check", "close_checks"]]
        self.review_strip = ReviewStrip(going, [actions["ignore_check"]])
        self.invalid_strip = ReviewStrip([], [actions["mark_suggested"], actions["ignore_suggested"]])
        self.cloud = CloudView(actions["cloud_raw"], actions["cloud_selected_only"], actions["cloud_beside"])
        self.toasts = Toasts(self, (self.views, self.cloud))
        self.notes = Notes(self, self.toasts, self.log)
        self.curves = CurvesPanel(self.panels.persistent)
        self.frames = FramesPanel()
        self.history = HistoryView(self.workspace.undo_group)
        self.blocks = BlockTable()
        self.filter_panel = FilterPanel(
            [actions[name] for name in ["run", "run_selected", "pause", "step", "cancel", "live"]],
            [actions[name] for name in ["copy_own", "reset_own"]],
            [actions[name] for name in ["share_parameters", "reset_to_shared"]],
        )
        self.extraction_panel = ExtractionPanel(actions["extract"])
        self.tool_bar = ToolBar(actions, self)
        self.view_bar = ViewBar(self.views, entries(actions, "contours_only block_names show_missing | fit"))
        self.experiments = ExperimentsMenu(self)
        self.drops = FileDrops(self)

    def _make_presenters(self) -> None:
        workspace, runs, loader, actions = self.workspace, self.runs, self.loader, self.actions_
        self.editor = Editor(workspace, self.views, self)
        self.block_commands = BlockCommands(workspace, self.editor)
        self.keys = ToolKeys(self, self.editor, self.views)
        self.documents = Documents(self, self.picture, workspace, loader, self.notes)
        self.replays = ReplayPresenter(self.notes)
        self.view_presenter = ViewsPresenter(workspace, self.views)
        self.errors = ErrorPresenter(workspace, runs, self.views)
        self.stages = StagePresenter(workspace, self.views, self.extraction_panel, self.notes, loader.is_extracting)
        self.block_presenter = BlocksPresenter(workspace, runs, self.blocks, entries(actions, BLOCK_MENU))
        self.filter_presenter = FilterPresenter(workspace, runs, self.filter_panel, actions["live"])
        self.sharing = SharingPresenter(workspace, self.filter_panel.frames, actions)
        self.live = LiveSolver(workspace, runs, actions["live"])
        self.effect = EditSummaryPresenter(
            workspace, runs, self.view_presenter, self.edit_summary_line, actions["live"]
        )
        self.review = ReviewPresenter(workspace, self.views, self.review_strip, actions["ignore_check"])
        self.invalid_depth = InvalidDepthPresenter(workspace, self.views, self.invalid_strip)
        self.curve_presenter = CurvesPresenter(workspace, self.curves)
        self.scrubbing = ScrubPresenter(workspace, runs, self.curves)
        self.cloud_presenter = CloudPresenter(workspace, self.editor, self.cloud, self.views, self.errors)
        tools = {name: actions[f"tool_{name}"] for name in self.editor.tools}
        self.tool_presenter = ToolsPresenter(self.editor, tools, self.tool_bar.options)
        self.context_menu = ContextMenu(workspace, self.editor, entries(actions, BLOCK_MENU), self.views)
        self.commands = CommandsPresenter(workspace, runs, loader, actions)
        self.status_presenter = StatusPresenter(
            workspace, runs, loader, self.documents, self.editor, self.status, self._hint_of_cloud
        )
        self.readout = ReadoutPresenter(workspace, self.status.readout)

    def _make_layout(self) -> None:
        strips = self.review_strip, self.invalid_strip, self.edit_summary_line
        self.centre = Centre(self.views, strips, self.cloud, self.view_bar)
        self.centre.turned.connect(lambda: self.tool_bar.show_options(not self.centre.shows_cloud_alone))
        self.setCentralWidget(self.centre)
        parameters = QTabWidget()
        parameters.setDocumentMode(True)
        parameters.addTab(self.filter_panel, "Filter")
        parameters.addTab(self.extraction_panel, "Extraction")
        area, docks = Qt.DockWidgetArea, self.panels
        # one column at the side, so that the images have the full height of the window
        docks.add("Frames", self.frames, area.RightDockWidgetArea, "ph.image", 1.8)
        docks.add("Blocks", self.blocks, area.RightDockWidgetArea, "ph.stack", 2.2, is_open=True)
        docks.add("Parameters", parameters, area.RightDockWidgetArea, "ph.sliders-horizontal", 3.2, is_open=True)
        docks.add("Convergence", self.curves, area.RightDockWidgetArea, "ph.chart-line", 2.6)
        docks.add("History", self.history, area.RightDockWidgetArea, "ph.clock-counter-clockwise", 1.8)
        docks.add("Log", self.log, area.BottomDockWidgetArea, "ph.list-dashes")
        self.setCorner(Qt.Corner.BottomLeftCorner, area.LeftDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, area.RightDockWidgetArea)
        self.setStatusBar(self.status)
        self.addToolBar(self.tool_bar)

    def _make_parts(self) -> None:
        """Make the features that have their own classes."""
        context = Context(
            self,
            self.workspace,
            self.runs,
            self.loader,
            self.views,
            self.cloud,
            self.view_presenter,
            self.editor,
            self.actions_,
            self.panels,
            self.refresh,
            self.notes,
            self.filter_panel,
            self.filter_presenter,
            self.errors,
            self.documents,
            self.centre,
            self.store,
            self.recorder,
            self._pending_work,
            self.frames.view.chosen,
        )
        self.frames_feature, self.project = FramesFeature(context, self.frames), ProjectFeature(context)
        autosave = AutosaveFeature(context, self.project.opening)
        self.parts: list[Feature] = [self.frames_feature, self.project, *(make(context) for make in _PARTS), autosave]
        fill_menu_bar(self.menuBar(), self.actions_, self.views, self.panels.toggles(), self.experiments)

    # connections

    def _connect_refresh(self) -> None:
        """Connect signals with the parts of the window that they make stale, in drawing order."""
        add, workspace, runs, views = self.refresh.add, self.workspace, self.runs, self.views
        turned, blocks, selected = (
            workspace.frames.session_changed,
            workspace.blocks.labels_changed,
            workspace.blocks.selection_changed,
        )
        infos, values = workspace.blocks.infos_changed, workspace.parameters.changed
        results, coming, depth = (
            workspace.runs.results_changed,
            workspace.runs.results_added,
            workspace.runs.previews_changed,
        )
        turned_to = self.centre.turned
        looked_at = views.shownChanged, turned_to
        named = self.view_presenter.names_toggled
        running, loading = runs.state_changed, self.loader.busy_changed
        add("picture", self.view_presenter.show_frame, (turned, workspace.blocks.invalid_mask_changed))
        add(
            "blocks",
            self.view_presenter.show_blocks,
            (turned, blocks, workspace.blocks.stroke_changed, infos, selected, named),
        )
        viewed_iteration = workspace.runs.viewed_iteration_changed
        add("depth", self.view_presenter.show_depth, (turned, blocks, results, viewed_iteration), (coming, depth))
        coloured = self.cloud.colours_changed
        add(
            "error",
            self.errors.show,
            (turned, blocks, results, workspace.runs.error_changed, running, coloured, *looked_at),
        )
        add(
            "cloud",
            self.cloud_presenter.show,
            (turned, blocks, infos, selected, results, self.cloud_presenter.changed, *looked_at),
            (coming,),
        )
        add(
            "table",
            self.block_presenter.show,
            (turned, blocks, infos, selected, values, results, running, workspace.blocks.block_errors_changed),
            (coming, workspace.runs.records_added),
        )
        add("filter", self.filter_presenter.show, (turned, infos, selected, values, self.filter_panel.scope_changed))
        add("sharing", self.sharing.show, (turned, values))
        shown_records = turned, blocks, infos, selected, values, results
        shown_also = workspace.runs.compared_changed, self.curves.shown
        going_on = coming, workspace.runs.records_added  # drawing at each batch would slow down the run
        add("curves", self.curve_presenter.show, (*shown_records, *shown_also), going_on)
        add("scrubbing", self.scrubbing.show, (turned, blocks, results, values), going_on)
        add(
            "stages",
            self.stages.show,
            (turned, workspace.parameters.extraction_changed, self.stages.changed, *looked_at),
        )
        add("extraction", self.stages.describe, (blocks, infos, self.stages.described))
        # not deferred: the next command may come before the next turn, and must be enabled or disabled by then
        for signal in (turned, blocks, infos, selected, results, values, running, loading, coming):
            signal.connect(lambda *_: self.commands.show())
        add("tools", self.tool_presenter.show, (turned, self.editor.tool_changed, self.editor.options_changed))
        hinted = self.editor.tool_changed, self.editor.hint_changed, self.cloud.canvas.hover_changed
        add("hint", self.status_presenter.show_hint, (turned, loading, turned_to, *hinted))
        exporting = self.documents.exporting_changed
        add("progress", self.status_presenter.show_progress, (turned, running, loading, exporting), (coming,))
        compared = workspace.runs.compared_changed, workspace.blocks.ground_truth_changed
        add(
            "readout",
            self.readout.show,
            (turned, blocks, infos, results, workspace.runs.error_changed, viewed_iteration, *compared),
            (coming, depth),
        )

    def _connect_commands(self) -> None:
        runs, editor, blocks, documents = self.runs, self.editor, self.block_commands, self.documents
        handlers: dict[str, Callable[[], object]] = {
            "open": documents.ask_open,
            "open_sample": documents.open_sample,
            "open_run": documents.ask_open_run,
            "load_blocks": documents.ask_load_blocks,
            "save_blocks": documents.ask_save_blocks,
            "export": documents.ask_export,
            "save_picture": documents.ask_save_picture,
            "close_frame": documents.close_frame,
            "quit": self.close,
            "extract": self.stages.extract,
            "new_block": blocks.new,
            "delete_blocks": blocks.delete,
            "merge_blocks": blocks.merge,
            "lock_blocks": blocks.toggle_locks,
            "hide_blocks": blocks.toggle_visibility,
            "mark_checked": blocks.mark_checked,
            "grow_blocks": blocks.grow,
            "shrink_blocks": blocks.shrink,
            "smooth_blocks": blocks.smooth,
            "clean_up": blocks.clean_up,
            "zoom_block": self.view_presenter.zoom_to_blocks,
            "select_all": blocks.select_all,
            "run": runs.start_changed,
            "run_all": runs.start,
            "run_selected": runs.start_selected,
            "pause": runs.toggle_pause,
            "step": runs.step,
            "cancel": runs.cancel,
            "extrapolate": runs.extrapolate,
            "reset_own": self.filter_presenter.reset_own,
            "copy_own": self.filter_presenter.copy_own,
            "share_parameters": self.sharing.share,
            "keep_own_parameters": self.sharing.keep,
            "reset_to_shared": self.sharing.reset,
            "separate_parameters": self.sharing.separate,
            "clear_results": runs.clear_results,
            "undo": editor.undo,
            "cancel_stroke": editor.escape,
            "brush_smaller": lambda: editor.step_brush(-1),
            "brush_larger": lambda: editor.step_brush(1),
            "next_check": lambda: self.review.go(1),
            "previous_check": lambda: self.review.go(-1),
            "ignore_check": self.review.leave,
            "close_checks": self.review.close,
            "suggest_invalid": self.invalid_depth.suggest,
            "mark_suggested": self.invalid_depth.take,
            "ignore_suggested": self.invalid_depth.leave,
            "fit": self.views.fit,
            "one_to_one": self.views.one_to_one,
            "shuffle_colours": self.block_presenter.shuffle_colours,
            "about": lambda: AboutDialog(self).open(),
            **{f"stage_{name}": partial(self.stages.show_stage, name) for name in STAGES},
        }
        for name, handler in handlers.items():
            self.actions_[name].triggered.connect(lambda _=False, handler=handler: handler())
        for key, name in ((Qt.Key.Key_B, "show_before_edit"), (Qt.Key.Key_V, "blink"), (Qt.Key.Key_X, "cloud_raw")):
            self.keys.hold(key, self.actions_[name])
        look = self.actions_["show_before_edit"]
        look.toggled.connect(self.effect.look)
        workspace = self.workspace
        edits = workspace.blocks.stroke_changed, workspace.blocks.labels_changed, workspace.blocks.invalid_mask_changed
        for changed in (workspace.frames.session_changed, *edits):
            changed.connect(lambda *_: look.setChecked(False))  # an edit shows the current state again
        self.actions_["full_screen"].toggled.connect(self._show_full_screen)
        self.actions_["contours_only"].toggled.connect(self.views.set_contours_only)
        self.actions_["block_names"].toggled.connect(self.view_presenter.show_names)
        self.actions_["show_missing"].toggled.connect(self.views.set_missing_shown)
        stage_cell = self.views.extraction
        self.actions_[f"stage_{stage_cell.stage}"].setChecked(True)
        stage_cell.stageChanged.connect(lambda name: self.actions_[f"stage_{name}"].setChecked(True))
        stages = {name: self.actions_[f"stage_{name}"] for name in STAGES}
        for action in stages.values():  # also when its shortcut changes
            action.changed.connect(lambda: stage_cell.set_hints({name: stages[name].toolTip() for name in stages}))
        stage_cell.set_hints({name: stages[name].toolTip() for name in stages})
        self.loader.extracted.connect(self.stages.hold)
        self.loader.busy_changed.connect(self.stages.go_on)
        self.loader.extracted.connect(self.editor.edge_data_source.hold)
        self.loader.replayed.connect(self.replays.show_differences)
        self.runs.finished.connect(self.replays.show_verdict)
        self.stages.extraction_requested.connect(self.loader.extract)
        self.stages.view_requested.connect(self.centre.show_images)
        self.review.shown.connect(self.centre.show_images)
        for name, tool in self.editor.tools.items():  # selecting a tool shows the images
            if not tool.points_only:
                self.actions_[f"tool_{name}"].triggered.connect(self.centre.show_images)
        self.actions_["cloud_beside"].toggled.connect(self.centre.set_side_by_side)
        self.runs.state_changed.connect(self._open_curves)
        self.workspace.frames.sessions_changed.connect(self._open_frames)
        self.views.set_pointer_handler(self._point)
        self.views.cursorMoved.connect(self.readout.point_at)
        self.views.contextMenuRequested.connect(self.context_menu.show)
        self.blocks.activated.connect(lambda _: self.view_presenter.zoom_to_blocks())

    def _connect_messages(self) -> None:
        notes = self.notes
        self.runs.ended.connect(notes.show_message)
        # after an edit, the edit summary is shown instead
        self.runs.resolved.connect(lambda text: None if self.effect.busy else notes.show_briefly(text))
        self.runs.failed.connect(lambda error: notes.report("The run failed", error))
        self.errors.failed.connect(lambda error: notes.report("Expected error", error))
        self.review.failed.connect(lambda error: notes.report("Quality check", error))
        self.invalid_depth.failed.connect(lambda error: notes.report("Suggesting invalid depth", error))
        self.cloud_presenter.failed.connect(lambda error: notes.report("Point cloud", error))
        self.invalid_depth.message.connect(notes.show_message)
        self.loader.failed.connect(notes.report)
        self.loader.message.connect(notes.show_message)
        self.editor.message.connect(notes.show_message)
        self.filter_presenter.message.connect(notes.show_message)
        self.sharing.message.connect(notes.show_message)
        self.editor.slivers_left.connect(
            lambda left: notes.offer(f"{counted(left, 'sliver')} left.", self.actions_["clean_up"])
        )
        self.editor.failed.connect(lambda error: notes.report("Edges of the frame", error))
        self.block_commands.message.connect(notes.show_message)
        self.experiments.message.connect(notes.show_message)

    def _point(self, event: PointerEvent) -> bool:
        self.refresh.now()  # the pointer event refers to what is drawn
        return self.editor.pointer(event)

    def _hint_of_cloud(self) -> str:
        """Return the mouse hint of the point cloud if the mouse is over it; "" otherwise."""
        if not (self.centre.shows_cloud_alone or self.cloud.canvas.underMouse()):
            return ""
        tool = self.editor.tool
        return f"{tool.hint} | {MOVES}" if tool.points_only else HINT

    def _open_curves(self) -> None:
        if self.runs.state is RunState.RUNNING:
            self.panels.offer("Convergence")

    def _open_frames(self) -> None:
        if len(self.workspace.frames.entries) > 1:
            self.panels.offer("Frames")

    def _show_full_screen(self, on: bool) -> None:
        (self.showFullScreen if on else self.showNormal)()

    def picture(self) -> QPixmap:
        """Return a screenshot of the window."""
        self.refresh.now()
        self.cloud.canvas.drawing.finish()
        return self.grab()

    # events

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Show that files would be accepted."""
        self.drops.enter(event)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """Hide the drop overlay."""
        self.drops.leave()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the dropped files."""
        if paths := self.drops.take(event):
            self.documents.open_paths(paths)

    def changeEvent(self, event: QEvent) -> None:
        """Redraw icons after a change of theme; update the full-screen action when the window state changes."""
        super().changeEvent(event)
        if not hasattr(self, "actions_"):  # during construction
            return
        if event.type() == QEvent.Type.PaletteChange:
            self.actions_.draw_icons()
            self.panels.draw_icons(self.palette())
        elif event.type() == QEvent.Type.WindowStateChange:
            with QSignalBlocker(self.actions_["full_screen"]):
                self.actions_["full_screen"].setChecked(self.isFullScreen())

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about unsaved work, stop the threads, store the layout."""
        if not self.project.may_close():
            event.ignore()
            return
        reviews = self.review, self.invalid_depth
        views = self.errors, self.effect, self.stages, self.editor, self.scrubbing, self.cloud_presenter
        for worker in (self.runs, *reviews, *views, self.loader, self.documents, self.experiments):
            worker.shutdown()
        for part in self.parts:
            part.shutdown()
        self.refresh.stop()
        self.panels.remember()
        super().closeEvent(event)

    def _pending_work(self) -> list[PendingWork]:
        """Return the pending background work, without runs of frames."""
        found = [way for part in self.parts for way in part.pending_work()]
        return [*found, PendingWork("an experiment")] if self.experiments.busy else found

    def showEvent(self, event: QShowEvent) -> None:
        """Restore the last layout, or use the default one; start deferred loading."""
        super().showEvent(event)
        self.panels.arrange()
        self.refresh.mark("error", "cloud", "stages")  # drawn only while visible
        self.experiments.load_soon()
