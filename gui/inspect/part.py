"""Looking closely: the depth along a line, a surface in numbers, distances and angles."""

from __future__ import annotations

from PySide6.QtCore import Qt

from gui.desk import Desk, Part
from gui.inspect.commands import COMMANDS
from gui.inspect.marks import InspectMarks, Marks
from gui.inspect.measure_panel import MeasurePanel
from gui.inspect.measure_presenter import MeasurePresenter
from gui.inspect.profile_panel import ProfilePanel
from gui.inspect.profile_presenter import ProfilePresenter


class InspectPart(Part):
    """Panels *Profile* and *Measure*, and what is drawn over the pictures with them."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        actions, workspace, editor = desk.actions, desk.workspace, desk.editor
        actions.add(COMMANDS)
        self.profile_panel = ProfilePanel(
            [actions[name] for name in ("tool_profile", "save_profile", "save_profile_picture")]
        )
        self.measure_panel = MeasurePanel(
            [actions[name] for name in ("tool_rectangle", "tool_measure")],
            [actions["copy_statistics"]],
            [actions[name] for name in ("copy_measurements", "save_measurements", "delete_measurements")],
        )
        self.inspection = editor.inspection
        self.measurements = editor.inspection.measurements
        self.profile = ProfilePresenter(desk, self.inspection, self.profile_panel)
        self.measure = MeasurePresenter(desk, self.inspection, self.measure_panel)
        desk.errors.watch(lambda: self.profile.is_seen and self.inspection.line is not None)
        self._marks = InspectMarks(desk.views)
        area = Qt.DockWidgetArea
        desk.panels.add("Profile", self.profile_panel, area.BottomDockWidgetArea, "ph.chart-line-up", 1.8)
        desk.panels.add("Measure", self.measure_panel, area.RightDockWidgetArea, "ph.ruler", 3.2)
        self._connect_refresh()
        for name, act in {
            "remove_marks": self._remove_marks,
            "save_profile": self.profile.save_table,
            "save_profile_picture": self.profile.save_picture,
            "copy_statistics": self.measure.copy_statistics,
            "copy_measurements": self.measure.copy,
            "save_measurements": self.measure.save,
            "delete_measurements": self.measure.delete,
            "restore_measurements": self.measure.restore,
        }.items():
            actions[name].triggered.connect(lambda _=False, act=act: act())
        actions["tool_profile"].triggered.connect(lambda _=False: desk.panels.reveal("Profile"))
        for page, tool in enumerate(("rectangle", "measure")):
            actions[f"tool_{tool}"].triggered.connect(lambda _=False, page=page: self._reveal(page))
        workspace.session_changed.connect(self._enable)
        self.measure.failed.connect(lambda error: desk.notes.report("Statistics", error))
        self._enable()

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread is left."""
        return self.measure.shutdown()

    def _connect_refresh(self) -> None:
        workspace, add = self.desk.workspace, self.desk.refresh.add
        turned, blocks, results = workspace.session_changed, workspace.labels_changed, workspace.results_changed
        coming = workspace.results_added, workspace.previews_changed
        depth = turned, blocks, results, workspace.distrusted_changed, workspace.past_changed
        line, measured = self.inspection.line_changed, self.measurements.changed
        seen = self.profile_panel.shown, self.measure_panel.shown
        compared = workspace.error_changed, workspace.truth_changed, workspace.compared_changed
        add("profile", self.profile.show, (*depth, *compared, workspace.infos_changed, line, seen[0]), coming)
        add("profile place", self.profile.follow, (self.desk.views.cursorMoved,))
        for signal in (line, seen[0]):
            signal.connect(lambda: self.desk.refresh.mark("error"))
        chosen = workspace.selection_changed, workspace.infos_changed, workspace.region_changed
        # not of previews: a run needs the processor more
        add("statistics", self.measure.ask, (*depth, *chosen, seen[1]), (workspace.results_added,))
        add("measurements", self.measure.show, (*depth, measured, seen[1], self.measure.found), coming)
        tool = self.desk.editor.tool_changed
        drawn = line, measured, workspace.region_changed, self.profile.place_changed, self.measure.found, tool
        add("inspect marks", self._show_marks, (*depth, *drawn, *seen), coming)
        for panel in (self.profile_panel, self.measure_panel):
            panel.hidden.connect(lambda: self.desk.refresh.mark("inspect marks"))

    def _show_marks(self) -> None:
        """What is drawn over the pictures: what the tool is for, or what an open panel is about."""
        workspace, tool = self.desk.workspace, self.desk.editor.tool_name
        if not workspace.has_session:
            self._show(Marks())
            return
        chains = self.measurements.chains if self.measure_panel.isVisible() or tool == "measure" else []
        plotted = self.profile.is_seen or tool == "profile"
        self._show(
            Marks(
                self.inspection.line if plotted else None,
                self.profile.place if plotted else None,
                workspace.session.region,
                chains,
                *(self.measure.texts() if chains else ()),
            )
        )

    def _show(self, marks: Marks) -> None:
        """Draw these over the pictures, and what is measured in the cloud."""
        self._marks.show(marks)
        self.desk.cloud.canvas.set_lines(marks.chains, [text for _, text in marks.lengths])

    def _reveal(self, page: int) -> None:
        """Show the page of statistics, or that of measurements."""
        self.desk.panels.reveal("Measure")
        self.measure_panel.pages.setCurrentIndex(page)

    def _remove_marks(self) -> None:
        self.inspection.set_line(None)
        self.inspection.set_region(None)

    def _enable(self) -> None:
        no_frame = "" if self.desk.workspace.has_session else "Open a frame first."
        self.desk.actions.allow(no_frame, *(command.name for command in COMMANDS))
