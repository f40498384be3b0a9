"""The main window: makes the state, the shared widgets, the features, the panels and the menus."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QCloseEvent, QDragEnterEvent, QDragLeaveEvent, QDropEvent, QShowEvent
from PySide6.QtWidgets import QDialog, QMainWindow, QTabWidget

from ilf._runtime.formatting import counted

from ..features.about import WindowFeature
from ..features.accuracy.panel import AccuracyPanel
from ..features.additional_depth import AdditionalDepthPanel
from ..features.blocks.commands import BlockCommands
from ..features.blocks.feature import BlocksFeature
from ..features.cloud import CloudPanel
from ..features.colour_range import ColourRange
from ..features.context import Context, Feature
from ..features.curves import CurvesFeature
from ..features.derived import DerivedFeature
from ..features.documents.feature import DocumentsFeature
from ..features.edit_summary import EditSummaryFeature
from ..features.expected_error import ErrorFeature
from ..features.extraction import ExtractionPanel
from ..features.filter import FilterPanel
from ..features.frame_list.feature import FramesFeature
from ..features.history import HistoryFeature
from ..features.inspect.panel import InspectPanel
from ..features.layouts import LayoutsFeature
from ..features.menus import ToolBar, ToolColumn, draw_extensions, fill_menu_bar
from ..features.on_use import OnUseFeature
from ..features.project.autosave import AutosaveFeature
from ..features.project.feature import ProjectFeature
from ..features.propagation import PropagationFeature
from ..features.quality import QualityPanel
from ..features.run_history.panel import RunsPanel
from ..features.runs import RunsFeature
from ..features.sequence.playing import PlayFeature
from ..features.sharing import SharingPanel
from ..features.shortcuts import ShortcutsFeature
from ..features.start_page import StartPageFeature
from ..features.status import StatusFeature
from ..features.tools import ToolsFeature
from ..features.views import ViewsFeature
from ..widgets.basics import Late
from ..widgets.docks import PanelGroup
from ..work.jobs import stop_workers
from .drops import FileDrops, accepted

# In the order in which they draw.
_STANDARD: tuple[type[Feature], ...] = (
    WindowFeature,
    ProjectFeature,
    DocumentsFeature,
    ViewsFeature,
    ErrorFeature,
    CloudPanel,
    BlockCommands,
    BlocksFeature,
    EditSummaryFeature,
    RunsFeature,
    FilterPanel,
    SharingPanel,
    CurvesFeature,
    ExtractionPanel,
    ToolsFeature,
    StatusFeature,
    FramesFeature,
    HistoryFeature,
)
_FURTHER: tuple[type[Feature], ...] = (
    RunsPanel,
    QualityPanel,
    PropagationFeature,
    OnUseFeature,
    AccuracyPanel,
    AdditionalDepthPanel,
    InspectPanel,
    DerivedFeature,
    ColourRange,
    StartPageFeature,
    PlayFeature,
    LayoutsFeature,
    ShortcutsFeature,
    AutosaveFeature,
)
"""Those with panels of their own add them after the standard ones."""


class MainWindow(QMainWindow):
    """The main window. It only assembles the shared objects and the features.

    With `persistent`, work is saved automatically, and restored.
    """

    def __init__(self, persistent: bool = True) -> None:
        super().__init__()
        self.context = context = Context(self, persistent)
        self.workspace, self.recorder, self.loader = context.workspace, context.recorder, context.loader
        self.runs, self.refresh, self.editor = context.runs, context.refresh, context.editor
        self.views, self.centre = context.views, context.centre
        self.panels, self.log, self.notes = context.panels, context.log, context.notes
        self.actions_, self.features, self.feature = context.actions, context.features, context.feature
        self.setCentralWidget(self.centre)
        FileDrops(self)
        for kind in _STANDARD:
            context.add(kind)
        self._add_panels()
        for kind in _FURTHER:
            context.add(kind)
        self.documents, self.project = self.feature(DocumentsFeature), self.feature(ProjectFeature)
        self._add_menus()
        self.feature(ShortcutsFeature).apply_keys()
        self.refresh.now()
        self.panels.place()
        self.panels.size_window()

    def _add_panels(self) -> None:
        """Add the standard panels."""
        feature = self.feature
        parameters = QTabWidget()
        parameters.setDocumentMode(True)
        parameters.addTab(feature(FilterPanel).widget, "Filter")
        parameters.addTab(Late(lambda: feature(ExtractionPanel).widget), "Extraction")
        feature(FilterPanel).form.menu_requested.connect(lambda *asked: feature(OnUseFeature).show_menu(*asked))
        self.panels.add("Log", self.log, PanelGroup.WORK, "ph.list-dashes")
        self.panels.add("Parameters", parameters, PanelGroup.SETTINGS, "ph.sliders-horizontal", is_open=True)

    def _add_menus(self) -> None:
        self.tool_bar = ToolBar(self.actions_, self.feature(ToolsFeature).options, self)
        self.addToolBar(self.tool_bar)
        self.tool_column = ToolColumn(self.actions_, self)
        self.addToolBar(Qt.ToolBarArea.LeftToolBarArea, self.tool_column)
        self.centre.turned.connect(lambda: self.tool_bar.show_options(not self.centre.shows_cloud_alone))
        fill_menu_bar(self.menuBar(), self.actions_, self.views, self.panels.toggles())
        self.feature(ViewsFeature).bar.shown.menu().addAction(self.actions_["fit_range"])
        draw_extensions(self)

    # events

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Say what a drop of files would do."""
        if paths := accepted(event):
            what = paths[0].name or str(paths[0]) if len(paths) == 1 else counted(len(paths), "item")
            self.statusBar().showMessage(f"Drop to open {what}")

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """Say so no more."""
        self.statusBar().clearMessage()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the dropped files."""
        self.statusBar().clearMessage()
        if paths := accepted(event):
            self.documents.open_paths(paths)

    def _show_state(self) -> None:
        with QSignalBlocker(self.actions_["full_screen"]):
            self.actions_["full_screen"].setChecked(self.isFullScreen())

    def closeEvent(self, event: QCloseEvent) -> None:
        """Ask about unsaved work, stop the threads, store the layout."""
        if not self.project.may_close():
            event.ignore()
            return
        stop_workers(self)
        for feature in self.features:
            feature.shutdown()
        for dialog in self.findChildren(QDialog):
            if dialog.isVisible():
                dialog.close()
        self.refresh.stop()
        self.panels.remember()
        super().closeEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Restore the last layout, or use the default one."""
        super().showEvent(event)
        self.windowHandle().windowStateChanged.connect(self._show_state, Qt.ConnectionType.UniqueConnection)
        self.panels.arrange()
        self.refresh.mark("error")  # drawn only while visible
