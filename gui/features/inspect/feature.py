"""Inspection: depth profile along a line, statistics of a surface, distances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ilf.data.label_map import Box
from ilf.evaluation.measuring import Line
from ilf.project.frame_state import Point

from ...base.commands import Command
from ...base.needs import Need
from ...views.linked_views import LinkedViews
from ...views.scene_items import ViewItem
from ...widgets.docks import PanelGroup
from ..context import Context, Feature
from ..views import ErrorFeature
from .measure_panel import MeasurePanel
from .measuring import MeasurePresenter
from .profile_panel import ProfilePanel, ProfilePresenter

# Profile line, rectangle and measurements drawn over the views.

_HEIGHT = 5.8
"""Z value: above the blocks' lines and names, below a tool's preview."""
_LINE, _REGION, _MEASURE = QColor(96, 220, 255), QColor(255, 255, 255), QColor(255, 176, 64)
_HALO, _PLATE = QColor(0, 0, 0, 190), QColor(0, 0, 0, 165)
_END, _PLACE, _DOT, _PAD = 4.0, 4.5, 3.5, 3.0
_BESIDE = 22.0
"""How far marks reach beyond their points, without texts [px]."""


@dataclass(frozen=True)
class Marks:
    """Marks over the views, in image coordinates.

    Attributes
    ----------
    line : pair of points, optional
        The profile line, from A to B.
    place : (float, float), optional
        A place on the line.
    region : (slice, slice), optional
        Rows and columns of the rectangle.
    measurements : sequence of pairs of points
    lengths : sequence of ((float, float), str)
        Texts at places.
    """

    line: Line | None = None
    place: Point | None = None
    region: Box | None = None
    measurements: Sequence[Line] = ()
    lengths: Sequence[tuple[Point, str]] = ()

    def extent(self) -> QRectF | None:
        """Return the bounding rectangle of all marks; None if nothing is marked."""
        points: list[Point] = [*(self.line or ()), *([self.place] if self.place else [])]
        points += [point for line in self.measurements for point in line]
        points += [place for place, _ in self.lengths]
        if self.region is not None:
            rows, columns = self.region
            points += [(columns.start, rows.start), (columns.stop, rows.stop)]
        return QPolygonF([QPointF(*point) for point in points]).boundingRect() if points else None


class _MarksItem(ViewItem):
    """Item that draws marks with lines, ends and texts of constant size on the screen."""

    def __init__(self) -> None:
        super().__init__(_HEIGHT)
        self._marks = Marks()
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)

    def set_marks(self, marks: Marks) -> None:
        """Set the marks to draw."""
        self._marks = marks
        metrics = QFontMetricsF(self._font)
        widest = max((metrics.horizontalAdvance(text) for _, text in marks.lengths), default=metrics.height())
        self.set_extent(marks.extent(), _BESIDE + widest / 2 + _PAD)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        marks, to_screen = self._marks, painter.worldTransform()

        def at(point: Point) -> QPointF:
            return to_screen.map(QPointF(*point))

        painter.save()
        painter.resetTransform()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(self._font)
        if marks.region is not None:
            rows, columns = marks.region
            self._draw_region(
                painter, QRectF(at((columns.start, rows.start)), at((columns.stop, rows.stop))).normalized()
            )
        if marks.line is not None:
            self._draw_line(painter, at(marks.line[0]), at(marks.line[1]))
        if marks.place is not None:
            _dot(painter, at(marks.place), _PLACE, _LINE)
        for line in marks.measurements:
            points = [at(point) for point in line]
            _stroke(painter, points, _MEASURE, 1.5)
            for point in points:
                _dot(painter, point, _DOT, _MEASURE)
        for place, text in marks.lengths:
            self._write(painter, at(place), text)
        painter.restore()

    def _draw_line(self, painter: QPainter, start: QPointF, end: QPointF) -> None:
        _stroke(painter, [start, end], _LINE, 1.5)
        painter.setPen(QPen(_HALO, 1.5))
        painter.setBrush(_LINE)
        for place in (start, end):
            painter.drawRect(QRectF(place.x() - _END, place.y() - _END, 2 * _END, 2 * _END))
        self._write(painter, start + _offset(end, start, 14), "A")
        self._write(painter, end + _offset(start, end, 14), "B")

    def _draw_region(self, painter: QPainter, rect: QRectF) -> None:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(_HALO, 3))
        painter.drawRect(rect)
        painter.setPen(QPen(_REGION, 1.4, Qt.PenStyle.DashLine))
        painter.drawRect(rect)
        painter.setPen(QPen(_HALO, 1))
        painter.setBrush(_REGION)
        for corner in (rect.topLeft(), rect.topRight(), rect.bottomLeft(), rect.bottomRight()):
            painter.drawRect(QRectF(corner.x() - 3, corner.y() - 3, 6, 6))

    def _write(self, painter: QPainter, place: QPointF, text: str) -> None:
        metrics = QFontMetricsF(self._font)
        plate = QRectF(0, 0, metrics.horizontalAdvance(text) + 2 * _PAD, metrics.height())
        plate.moveCenter(place)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(_PLATE)
        painter.drawRoundedRect(plate, 3, 3)
        painter.setPen(QColor("white"))
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)


def _offset(start: QPointF, end: QPointF, length: float) -> QPointF:
    """Return a vector of a length [px] in the direction from one point to another."""
    way = end - start
    return way * (length / max(math.hypot(way.x(), way.y()), 1e-6))


class InspectMarks:
    """The same marks in every view."""

    def __init__(self, views: LinkedViews) -> None:
        self._views = views
        self._items: dict[str, _MarksItem] = {}
        self.marks = Marks()
        for name, cell in views.cells.items():
            self._items[name] = _MarksItem()
            cell.view.add_overlay(self._items[name])

    def show(self, marks: Marks) -> None:
        """Draw these marks only."""
        if marks != self.marks:
            self.marks = marks
            for item in self._items.values():
                item.set_marks(marks)


def _stroke(painter: QPainter, points: list[QPointF], colour: QColor, width: float) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in (QPen(_HALO, width + 2), QPen(colour, width)):
        painter.setPen(pen)
        painter.drawPolyline(points)


def _dot(painter: QPainter, place: QPointF, radius: float, colour: QColor) -> None:
    painter.setPen(QPen(_HALO, 1.5))
    painter.setBrush(colour)
    painter.drawEllipse(place, radius, radius)


class InspectFeature(Feature):
    """Panels *Profile* and *Measure*, with their marks over the views."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        actions, editor = context.actions, context.editor
        actions.add(self._commands())
        self.profile_panel = ProfilePanel(
            [actions[name] for name in ("tool_profile", "save_profile", "save_profile_picture")]
        )
        self.measure_panel = MeasurePanel(
            [actions[name] for name in ("tool_rectangle", "tool_measure")],
            [actions["copy_statistics"]],
            [actions[name] for name in ("copy_measurements", "save_measurements", "delete_measurements")],
        )
        self.inspection = editor.inspection
        self.profile = ProfilePresenter(context, self.inspection, self.profile_panel)
        self.measure = MeasurePresenter(context, self.inspection, self.measure_panel)
        context.feature(ErrorFeature).watch(lambda: self.profile.is_seen and self.inspection.line is not None)
        self._marks = InspectMarks(context.views)
        context.panels.add("Profile", self.profile_panel, PanelGroup.INSPECTION, "ph.chart-line-up")
        context.panels.add("Measure", self.measure_panel, PanelGroup.INSPECTION, "ph.ruler")
        self._connect_refresh()
        actions["tool_profile"].triggered.connect(lambda _=False: context.panels.reveal("Profile"))
        for page, tool in enumerate(("rectangle", "measure")):
            actions[f"tool_{tool}"].triggered.connect(lambda _=False, page=page: self._reveal(page))
        self.measure.failed.connect(lambda error: context.notes.report("Statistics", error))

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "remove_marks",
                "Remo&ve line and rectangle",
                "Remove the profile line and the rectangle",
                icon="ph.x",
                handler=self._remove_marks,
                needs=Need.FRAME,
            ),
            Command(
                "save_profile",
                "Save profile as &table…",
                "Write the depth along the profile line as CSV",
                icon="ph.table",
                handler=lambda: self.profile.save_table(),
                needs=Need.FRAME,
            ),
            Command(
                "save_profile_picture",
                "Save profile as p&icture…",
                "Write the plot as PNG or SVG",
                icon="ph.image",
                handler=lambda: self.profile.save_picture(),
                needs=Need.FRAME,
            ),
            Command(
                "copy_statistics",
                "Copy &statistics",
                "Copy the statistics as a tab-separated table",
                icon="ph.copy",
                handler=lambda: self.measure.copy_statistics(),
                needs=Need.FRAME,
            ),
            Command(
                "copy_measurements",
                "&Copy measurements",
                "Copy the measurements as a tab-separated table",
                icon="ph.copy",
                handler=lambda: self.measure.copy(),
                needs=Need.FRAME,
            ),
            Command(
                "save_measurements",
                "Save m&easurements…",
                "Write the measurements as CSV",
                icon="ph.floppy-disk",
                handler=lambda: self.measure.save(),
                needs=Need.FRAME,
            ),
            Command(
                "delete_measurements",
                "&Delete measurements",
                "Delete the measurements selected in the list, or all if none is selected",
                icon="ph.trash",
                handler=lambda: self.measure.delete(),
                needs=Need.FRAME,
            ),
            Command(
                "restore_measurements",
                "Restore measurements",
                "Restore the measurements that were deleted last",
                handler=lambda: self.measure.restore(),
                needs=Need.FRAME,
            ),
        )

    def _connect_refresh(self) -> None:
        workspace, add = self.context.workspace, self.context.refresh.add
        turned, blocks, results = (
            workspace.frames.session_changed,
            workspace.labels_changed,
            workspace.runs.results_changed,
        )
        coming = workspace.runs.results_added, workspace.runs.previews_changed
        known = workspace.blocks.invalid_mask_changed, workspace.blocks.neighbours_changed
        depth = turned, blocks, results, *known, workspace.runs.viewed_iteration_changed
        line, measured = self.inspection.line_changed, self.inspection.measurements_changed
        seen = self.profile_panel.shown, self.measure_panel.shown
        compared = workspace.runs.error_changed, workspace.blocks.ground_truth_changed, workspace.runs.compared_changed
        add("profile", self.profile.show, (*depth, *compared, workspace.blocks.infos_changed, line, seen[0]), coming)
        add("profile place", self.profile.follow, (self.context.views.cursorMoved,))
        for signal in (line, seen[0]):
            signal.connect(lambda: self.context.refresh.mark("error"))
        chosen = workspace.blocks.selection_changed, workspace.blocks.infos_changed, workspace.blocks.region_changed
        # not updated for previews, to leave the processor to the run
        add("statistics", self.measure.ask, (*depth, *chosen, seen[1]), (workspace.runs.results_added,))
        add("measurements", self.measure.show, (*depth, measured, seen[1], self.measure.found), coming)
        tool = self.context.editor.tool_changed
        drawn = line, measured, workspace.blocks.region_changed, self.profile.place_changed, self.measure.found, tool
        add("inspect marks", self._show_marks, (*depth, *drawn, *seen), coming)
        for panel in (self.profile_panel, self.measure_panel):
            panel.hidden.connect(lambda: self.context.refresh.mark("inspect marks"))

    def _show_marks(self) -> None:
        """Draw the marks of the tool and of the open panels over the views."""
        workspace, tool = self.context.workspace, self.context.editor.tool_name
        if not workspace.has_current:
            self._show(Marks())
            return
        lines = self.inspection.measurements if self.measure_panel.isVisible() or tool == "measure" else ()
        plotted = self.profile.is_seen or tool == "profile"
        self._show(
            Marks(
                self.inspection.line if plotted else None,
                self.profile.place if plotted else None,
                workspace.current.state.looked.region,
                lines,
                self.measure.texts() if lines else (),
            )
        )

    def _show(self, marks: Marks) -> None:
        """Draw marks over the views, and measurements in the cloud."""
        self._marks.show(marks)
        self.context.cloud.canvas.set_lines(marks.measurements, [text for _, text in marks.lengths])

    def _reveal(self, page: int) -> None:
        """Show the page of the statistics (0) or of the measurements (1)."""
        self.context.panels.reveal("Measure")
        self.measure_panel.pages.setCurrentIndex(page)

    def _remove_marks(self) -> None:
        self.inspection.set_line(None)
        self.inspection.set_region(None)
