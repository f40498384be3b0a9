"""The main window: docks, menus, and the wiring between workspace, controllers and widgets."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QSettings, Qt
from PySide6.QtGui import QActionGroup, QCloseEvent, QDragEnterEvent, QDropEvent, QShowEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDockWidget,
    QLabel,
    QMainWindow,
    QMenu,
    QProgressBar,
    QSlider,
    QTabWidget,
    QToolBar,
    QWidget,
)

from gui import theme
from gui.actions import Actions
from gui.blocks.block_table import BlockTable
from gui.cloud.cloud_view import CloudView
from gui.curves.curves_panel import CurvesPanel
from gui.experiments.menu import ExperimentsMenu
from gui.extraction.extraction_panel import ExtractionPanel
from gui.extraction.stage_presenter import StagePresenter
from gui.filtering.filter_panel import FilterPanel
from gui.frames.documents import Documents
from gui.frames.frame_list import FrameList
from gui.frames.loader import FrameLoader
from gui.presenter import Presenter
from gui.state.workspace import Workspace
from gui.tools.editor import Editor
from gui.views.colour_maps import DEPTH_MAPS
from gui.views.linked_views import LAYOUTS, LinkedViews
from gui.widgets.log import LogPanel
from gui.work.expected_errors import ExpectedErrors
from gui.work.runs import RunController
from ilf.drawing.stages import STAGES

_LAYOUT_TEXTS = {
    "grid": "Four views",
    "grid-difference": "Four, difference",
    "grid-extraction": "Four, extraction",
    "row": "Side by side",
    "colour": "Colour + blocks",
    "depth-in": "Depth in",
    "depth-out": "Depth out",
    "difference": "Difference",
    "expected-error": "Expected error",
    "extraction": "Extraction",
}
_OPACITY = 45
DEFAULT_SIZE = (1440, 900)


class MainWindow(QMainWindow):
    """Wiring only: state lives in the workspace, work is done by the controllers.

    With `remembers`, size and docks are those of the last time, and are kept for the next.
    """

    def __init__(self, remembers: bool = True) -> None:
        super().__init__()
        self._remembers = remembers
        self._arranged = False
        self.setWindowTitle("ILF Studio")
        self.setAcceptDrops(True)
        self.setDockOptions(QMainWindow.DockOption.AnimatedDocks | QMainWindow.DockOption.AllowTabbedDocks)
        self.workspace = Workspace(self)
        self.loader = FrameLoader(self.workspace, self)
        self.runs = RunController(self.workspace, self)
        self.errors = ExpectedErrors(self)
        self.actions_ = Actions(self)

        self.views = LinkedViews()
        self.cloud = CloudView()
        self.curves = CurvesPanel()
        self.log = LogPanel()
        self.frames = FrameList()
        self.blocks = BlockTable()
        run_actions = [self.actions_[name] for name in ("run", "run_selected", "pause", "step", "cancel", "live")]
        self.filter_panel = FilterPanel(run_actions)
        self.extraction_panel = ExtractionPanel(self.actions_["extract"])
        self.editor = Editor(self.workspace, self.views, self)
        self.documents = Documents(self, self.workspace, self.loader, self.runs)
        self.presenter = Presenter(self)
        self.stages = StagePresenter(self)

        self.centre = QTabWidget()
        self.centre.setDocumentMode(True)
        self.centre.addTab(self.views, "Images")
        self.centre.addTab(self.cloud, "Point cloud")
        self.setCentralWidget(self.centre)
        self._make_docks()
        self._make_status_bar()
        self._undo = self.workspace.undo_group.createUndoAction(self, "Undo")
        self._redo = self.workspace.undo_group.createRedoAction(self, "Redo")
        self._undo.setShortcut("Ctrl+Z")
        self._redo.setShortcuts(["Ctrl+Shift+Z", "Ctrl+Y"])
        self._draw_icons()
        self._make_menus()
        self._make_tool_bar()
        self._connect()
        self.views.set_overlay_opacity(_OPACITY / 100)
        self.presenter.show_session()
        geometry = QSettings().value("window/geometry") if remembers else None
        if geometry is None or not self.restoreGeometry(geometry):
            self.resize(*DEFAULT_SIZE)

    # layout

    def _make_docks(self) -> None:
        areas = Qt.DockWidgetArea
        self._docks: list[QDockWidget] = []
        frames = self._dock("Frames", self.frames, areas.LeftDockWidgetArea)
        blocks = self._dock("Blocks", self.blocks, areas.LeftDockWidgetArea)
        parameters = QTabWidget()
        parameters.setDocumentMode(True)
        parameters.addTab(self.filter_panel, "Filter")
        parameters.addTab(self.extraction_panel, "Extraction")
        self.parameter_tabs = parameters
        right = self._dock("Parameters", parameters, areas.RightDockWidgetArea)
        curves = self._dock("Convergence", self.curves, areas.BottomDockWidgetArea)
        log = self._dock("Log", self.log, areas.BottomDockWidgetArea)
        self.tabifyDockWidget(curves, log)
        curves.raise_()
        self.setCorner(Qt.Corner.BottomLeftCorner, areas.LeftDockWidgetArea)
        self.setCorner(Qt.Corner.BottomRightCorner, areas.RightDockWidgetArea)
        self._sized_docks = frames, blocks, right, curves

    def _arrange(self) -> None:
        """Default sizes of the docks: enough for their content where the window is large, a share of it where not."""
        frames, blocks, right, curves = self._sized_docks
        left_width, right_width = min(430, round(0.3 * self.width())), min(310, round(0.24 * self.width()))
        self.resizeDocks([frames, right], [left_width, right_width], Qt.Orientation.Horizontal)
        self.resizeDocks([frames, blocks], [170, 600], Qt.Orientation.Vertical)
        self.resizeDocks([curves], [min(230, round(0.25 * self.height()))], Qt.Orientation.Vertical)

    def _dock(self, title: str, widget: QWidget, area: Qt.DockWidgetArea) -> QDockWidget:
        dock = QDockWidget(title, self)
        dock.setObjectName(title)
        dock.setWidget(widget)
        self.addDockWidget(area, dock)
        self._docks.append(dock)
        return dock

    def _make_status_bar(self) -> None:
        self.hint = QLabel()
        self.hint.setMinimumWidth(0)
        self.readout = QLabel()
        self.progress = QProgressBar()
        self.progress.setFixedWidth(160)
        self.progress.setTextVisible(True)
        self.progress.hide()
        self.statusBar().addWidget(self.hint, 1)
        self.statusBar().addPermanentWidget(self.readout)
        self.statusBar().addPermanentWidget(self.progress)

    def _make_menus(self) -> None:
        entries = {
            "&File": "open open_sample open_run | load_blocks export save_picture | close_frame quit",
            "&Edit": "undo redo | select_all delete_blocks merge_blocks lock_blocks new_block | tool_select "
            "tool_paint tool_erase tool_split | brush_smaller brush_larger give_up",
            "&Blocks": "extract | new_block delete_blocks merge_blocks lock_blocks | zoom_block select_all",
            "&Run": "run run_selected | pause step cancel | live | clear_results",
        }
        for title, names in entries.items():
            self._fill(self.menuBar().addMenu(title), names)
        view = self.menuBar().addMenu("&View")
        self._fill(view, "fit one_to_one zoom_block | next_frame previous_frame")
        view.addSeparator()
        for dock in self._docks:
            view.addAction(dock.toggleViewAction())
        view.addSeparator()
        view.addMenu(self._layout_menu())
        self._fill(view.addMenu("&Stage of the extraction"), " ".join(f"stage_{name}" for name in STAGES))
        view.addMenu(self._depth_map_menu())
        view.addMenu(self.documents.theme_menu())
        self.experiments = ExperimentsMenu(self)
        self.experiments.message.connect(self.documents.tell)
        self.menuBar().addMenu(self.experiments)
        self._fill(self.menuBar().addMenu("&Help"), "about")

    def _layout_menu(self) -> QMenu:
        menu = QMenu("&Layout", self)
        group = QActionGroup(menu)
        for name in LAYOUTS:
            if name == LAYOUTS[len(LAYOUTS) - len(self.views.cells)]:
                menu.addSeparator()
            action = menu.addAction(_LAYOUT_TEXTS[name])
            action.setCheckable(True)
            action.setChecked(name == LAYOUTS[0])
            group.addAction(action)
            action.triggered.connect(lambda _=False, name=name: self.views.set_layout(name))
            self.views.layoutChanged.connect(lambda shown, name=name, action=action: action.setChecked(shown == name))
        return menu

    def _depth_map_menu(self) -> QMenu:
        menu = QMenu("Depth &colours", self)
        group = QActionGroup(menu)
        for name in DEPTH_MAPS:
            action = menu.addAction(name.capitalize())
            action.setCheckable(True)
            action.setChecked(name == next(iter(DEPTH_MAPS)))
            group.addAction(action)
            action.triggered.connect(lambda _=False, name=name: self.views.set_depth_map(name))
        return menu

    def _fill(self, menu: QMenu | QToolBar, names: str) -> None:
        own = {"undo": self._undo, "redo": self._redo}
        for name in names.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(own.get(name) or self.actions_[name])

    def _make_tool_bar(self) -> None:
        bar = QToolBar("Tools")
        bar.setObjectName("Tools")
        bar.setMovable(False)
        self._fill(bar, "open export | undo redo | tool_select tool_paint tool_erase tool_split")
        self.brush = QSlider(Qt.Orientation.Horizontal)
        self.brush.setRange(1, 60)
        self.brush.setFixedWidth(80)
        self.brush_label = QLabel()
        bar.addWidget(self.brush_label)
        bar.addWidget(self.brush)
        self._fill(bar, "| new_block merge_blocks delete_blocks |")
        bar.addWidget(QLabel(" Blocks "))
        self.opacity = QSlider(Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setValue(_OPACITY)
        self.opacity.setFixedWidth(80)
        self.opacity.setToolTip("Opacity of the blocks over the colour image")
        bar.addWidget(self.opacity)
        self.layouts = QComboBox()
        for name in LAYOUTS:
            self.layouts.addItem(_LAYOUT_TEXTS[name], name)
        self.layouts.setToolTip("Which views are shown; a double-click on a title shows one alone")
        bar.addSeparator()
        bar.addWidget(self.layouts)
        self._fill(bar, "fit")
        self.addToolBar(bar)

    # wiring

    def _connect(self) -> None:
        workspace, runs, editor, presenter = self.workspace, self.runs, self.editor, self.presenter
        documents = self.documents
        handlers = {
            "open": documents.ask_open,
            "open_sample": documents.open_sample,
            "open_run": documents.ask_open_run,
            "load_blocks": documents.ask_load_blocks,
            "export": documents.ask_export,
            "save_picture": documents.ask_save_picture,
            "close_frame": documents.close_frame,
            "quit": self.close,
            "extract": self.stages.extract,
            "new_block": editor.new_block,
            "delete_blocks": editor.delete_selected,
            "merge_blocks": editor.merge_selected,
            "lock_blocks": editor.toggle_locks,
            "zoom_block": presenter.zoom_to_block,
            "select_all": editor.select_all,
            "run": runs.start,
            "run_selected": lambda: runs.start(set(workspace.session.selected) & set(workspace.session.counts())),
            "step": self._step,
            "cancel": runs.cancel,
            "clear_results": runs.clear_results,
            "give_up": editor.cancel,
            "brush_smaller": lambda: editor.change_brush(-1),
            "brush_larger": lambda: editor.change_brush(1),
            "fit": self.views.fit,
            "one_to_one": self.views.one_to_one,
            "next_frame": lambda: documents.turn(1),
            "previous_frame": lambda: documents.turn(-1),
            "about": documents.about,
        }
        for name, handler in handlers.items():
            self.actions_[name].triggered.connect(lambda _=False, handler=handler: handler())
        self.actions_["pause"].triggered.connect(self._pause)
        self.actions_["live"].setChecked(QSettings().value("live", True, type=bool))
        self.actions_["live"].toggled.connect(lambda checked: QSettings().setValue("live", checked))
        for name in editor.tools:
            self.actions_[f"tool_{name}"].triggered.connect(lambda _=False, name=name: editor.set_tool(name))

        self._connect_extraction()

        workspace.sessions_changed.connect(presenter.show_frames)
        workspace.session_changed.connect(presenter.show_session)
        workspace.session_changed.connect(self.stages.refresh)
        workspace.labels_changed.connect(presenter.show_labels)
        workspace.infos_changed.connect(presenter.show_infos)
        workspace.results_changed.connect(presenter.show_results)
        workspace.selection_changed.connect(presenter.show_selection)
        workspace.parameters_changed.connect(presenter.show_parameters)
        runs.state_changed.connect(presenter.show_run_state)
        runs.block_started.connect(presenter.start_curves)
        runs.records.connect(presenter.add_records)
        runs.previewed.connect(presenter.show_preview)
        runs.ended.connect(documents.tell)
        runs.ended.connect(lambda _: presenter.show_curves())
        runs.resolved.connect(lambda text: self.statusBar().showMessage(text, 4000))
        runs.failed.connect(lambda error: documents.report("The run stopped", error))
        runs.state_changed.connect(presenter.show_expected_error)
        self.errors.found.connect(presenter.take_expected_error)
        self.errors.failed.connect(lambda error: documents.report("Expected error", error))
        self.loader.busy_changed.connect(presenter.show_loading)
        self.loader.failed.connect(documents.report)
        self.loader.message.connect(documents.tell)
        editor.message.connect(documents.tell)
        editor.tool_changed.connect(presenter.show_tool)
        editor.brush_changed.connect(presenter.show_brush)
        self.brush.valueChanged.connect(presenter.take_brush)
        self.opacity.valueChanged.connect(lambda value: self.views.set_overlay_opacity(value / 100))
        self.layouts.activated.connect(lambda _: self.views.set_layout(self.layouts.currentData()))
        self.views.layoutChanged.connect(lambda name: self.layouts.setCurrentIndex(LAYOUTS.index(name)))
        self.views.layoutChanged.connect(lambda _: presenter.show_expected_error())
        self.views.cursorMoved.connect(presenter.show_readout)
        self.views.contextMenuRequested.connect(presenter.show_context_menu)
        self.centre.currentChanged.connect(lambda _: presenter.show_cloud())
        self.centre.currentChanged.connect(lambda _: presenter.show_expected_error())
        self.frames.activated.connect(documents.show_frame)
        self.frames.removeRequested.connect(documents.remove_frame)
        self.blocks.selectionChanged.connect(workspace.select)
        self.blocks.renamed.connect(lambda label, name: workspace.edit_info(label, "Rename block", name=name))
        self.blocks.recoloured.connect(
            lambda label, colour: workspace.edit_info(label, "Recolour block", colour=colour.getRgb()[:3])
        )
        self.blocks.visibilityChanged.connect(workspace.set_visible)
        self.blocks.lockChanged.connect(editor.set_lock)
        self.blocks.activated.connect(lambda _: presenter.zoom_to_block())
        self.blocks.contextMenuRequested.connect(lambda place, _: presenter.show_block_menu(place))
        self.filter_panel.edited.connect(presenter.take_parameters)
        self.filter_panel.scope_changed.connect(presenter.show_parameters)

    def _connect_extraction(self) -> None:
        stages, panel = self.stages, self.extraction_panel
        for name in STAGES:
            self.actions_[f"stage_{name}"].triggered.connect(lambda _=False, name=name: stages.show_stage(name))
        self.actions_[f"stage_{self.views.extraction.stage}"].setChecked(True)
        self.views.extraction.stageChanged.connect(lambda name: self.actions_[f"stage_{name}"].setChecked(True))
        self.views.extraction.stageChanged.connect(lambda _: stages.refresh())
        self.views.layoutChanged.connect(lambda _: stages.refresh())
        self.centre.currentChanged.connect(lambda _: stages.refresh())
        self.views.extraction.set_hints({name: self.actions_[f"stage_{name}"].toolTip() for name in STAGES})
        self.workspace.labels_changed.connect(lambda _: stages.describe())
        self.workspace.infos_changed.connect(stages.describe)
        self.loader.extracted.connect(stages.hold)
        panel.edited.connect(stages.take_parameters)
        panel.preview_switched.connect(stages.switch)
        panel.keeping_switched.connect(stages.take_keeping)
        panel.view_wished.connect(stages.show_view)

    def _pause(self, checked: bool) -> None:
        (self.runs.pause if checked else self.runs.resume)()

    def _step(self) -> None:
        """One iteration: of the run under way, or of a new one over the chosen blocks, or all."""
        if self.runs.free:
            chosen = set(self.workspace.session.selected) & set(self.workspace.session.counts())
            self.runs.start(chosen or None, stepwise=True)
        else:
            self.runs.step()

    # events

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Take files."""
        if event.mimeData().hasUrls():
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open what was dropped."""
        paths = [url.toLocalFile() for url in event.mimeData().urls() if url.isLocalFile()]
        if paths:
            event.acceptProposedAction()
            self.documents.open_paths([Path(path) for path in paths])

    def changeEvent(self, event: QEvent) -> None:
        """Redraw icons for another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_redo"):
            self._draw_icons()

    def _draw_icons(self) -> None:
        self.actions_.draw_icons()
        self._undo.setIcon(theme.icon("ph.arrow-counter-clockwise", self.palette()))
        self._redo.setIcon(theme.icon("ph.arrow-clockwise", self.palette()))

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about what is not exported, stop the threads, remember the layout."""
        if not self.documents.may_close():
            event.ignore()
            return
        self.runs.shutdown()
        self.errors.shutdown()
        self.stages.shutdown()
        self.loader.shutdown()
        self.documents.shutdown()
        self.experiments.shutdown()
        if self._remembers:
            settings = QSettings()
            settings.setValue("window/geometry", self.saveGeometry())
            settings.setValue("window/state", self.saveState())
        super().closeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Take the last layout, or at the first start the default one: docks take sizes only in a shown window."""
        super().showEvent(event)
        if self._arranged:
            return
        self._arranged = True
        self.experiments.load_soon()
        state = QSettings().value("window/state") if self._remembers else None
        if state is None or not self.restoreState(state):
            self._arrange()
