"""The range of the colours: its panel, and what is done there."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt

from gui.desk import Desk, Part
from gui.levels.commands import COMMANDS
from gui.levels.range_panel import RangePanel
from gui.views.ranges import FIXED

_TITLE = "Range"


class RangePart(Part):
    """The range of what the active view shows; one range for all depths, one for all differences and errors."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        workspace, views, actions = desk.workspace, desk.views, desk.actions
        actions.add(COMMANDS)
        self._lock = actions["lock_range"]
        self.panel = RangePanel(self._lock)
        desk.panels.add(_TITLE, self.panel, Qt.DockWidgetArea.RightDockWidgetArea, "ph.chart-bar", 1.8)
        changed = workspace.session_changed, workspace.results_changed, workspace.error_changed
        shown = views.rangeChanged, views.shownChanged, workspace.compared_changed, workspace.truth_changed
        later = workspace.results_added, workspace.previews_changed
        desk.refresh.add("range", self.show, (*changed, *shown, self.panel.shown), later)
        actions["show_range"].triggered.connect(lambda: desk.panels.reveal(_TITLE))
        self._lock.toggled.connect(self._set_lock)
        self.panel.modeChosen.connect(self._set_mode)
        self.panel.levelsSet.connect(self._set_levels)
        self.panel.mapChosen.connect(views.set_depth_map)

    def show(self) -> None:
        """The range of the active view, if anybody looks; whether it is locked in any case."""
        views = self.desk.views
        cell, kind = views.ranged, views.ranged.painter.range_kind
        there = self.desk.workspace.has_session and bool(kind) and cell.bar.levels is not None
        with QSignalBlocker(self._lock):
            self._lock.setChecked(there and views.ranges.of(kind).locked)
        self._lock.setEnabled(there)
        if not self.panel.isVisible():
            return
        self.panel.show_map(views.ranges.depth_map)
        if there and cell.bar.levels is not None:
            values = cell.painter.values()
            self.panel.show_range(cell.strip.title, kind, values, cell.bar.levels, views.ranges.of(kind))
        else:
            self.panel.show_nothing(cell.strip.title, "Click on a view of depth, a difference or an error")

    def _set_mode(self, mode: str) -> None:
        cell = self.desk.views.ranged
        kind, levels = cell.painter.range_kind, cell.bar.levels
        self.desk.views.ranges.set(kind, mode, levels if mode == FIXED else None)

    def _set_levels(self, low: float, high: float) -> None:
        views = self.desk.views
        if low < high:
            views.ranges.set(views.ranged.painter.range_kind, FIXED, (low, high))
        else:
            self.desk.notes.tell("The lower end of the colours must be below the upper one.")
            self.desk.refresh.mark("range")

    def _set_lock(self, on: bool) -> None:
        """Keep what is to be seen now, or find the range again."""
        views = self.desk.views
        kind, levels = views.ranged.painter.range_kind, views.ranged.bar.levels
        if kind:
            views.ranges.set(kind, views.ranges.of(kind).mode, levels if on else None, locked=on)
