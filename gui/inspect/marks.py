"""Profile line, rectangle and measurements over the pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from gui.state.chains import Point
from gui.state.inspection import Line
from gui.views.items import ViewItem
from gui.views.linked_views import LinkedViews
from ilf.blocks import Box

_HEIGHT = 5.8
"""Over the blocks' lines and names, below a tool's preview."""
_LINE, _REGION, _MEASURE = QColor(96, 220, 255), QColor(255, 255, 255), QColor(255, 176, 64)
_HALO, _PLATE = QColor(0, 0, 0, 190), QColor(0, 0, 0, 165)
_END, _PLACE, _DOT, _PAD = 4.0, 4.5, 3.5, 3.0
_BESIDE = 22.0
"""How far from its place the middle of a text is [px]."""


@dataclass(frozen=True)
class Marks:
    """What is marked, in image coordinates.

    Attributes
    ----------
    line : pair of points, optional
        The profile line, from A to B.
    place : (float, float), optional
        A place on it.
    region : (slice, slice), optional
        Rows and columns of the rectangle.
    chains : sequence of sequence of (float, float)
        The points that are measured between, straight from one to the next.
    lengths : sequence of ((float, float), str)
        What is written on places.
    angles : sequence of ((float, float), (float, float), str)
        What is written beside places, on the far side of others.
    """

    line: Line | None = None
    place: Point | None = None
    region: Box | None = None
    chains: Sequence[Sequence[Point]] = ()
    lengths: Sequence[tuple[Point, str]] = ()
    angles: Sequence[tuple[Point, Point, str]] = ()

    def extent(self) -> QRectF | None:
        """What all of the places lie in; None if nothing is marked."""
        points: list[Point] = [*(self.line or ()), *([self.place] if self.place else [])]
        points += [point for chain in self.chains for point in chain]
        points += [place for place, _ in self.lengths]
        points += [place for place, _, _ in self.angles]
        if self.region is not None:
            rows, columns = self.region
            points += [(columns.start, rows.start), (columns.stop, rows.stop)]
        return QPolygonF([QPointF(*point) for point in points]).boundingRect() if points else None


class _MarksItem(ViewItem):
    """Draws marks with lines, ends and texts of one size on the screen at every zoom."""

    def __init__(self) -> None:
        super().__init__(_HEIGHT)
        self._marks = Marks()
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)

    def set_marks(self, marks: Marks) -> None:
        """Draw other marks."""
        self._marks = marks
        metrics = QFontMetricsF(self._font)
        texts = [*(text for _, text in marks.lengths), *(text for _, _, text in marks.angles)]
        widest = max((metrics.horizontalAdvance(text) for text in texts), default=metrics.height())
        self.set_extent(marks.extent(), _BESIDE + widest / 2 + _PAD + metrics.height())

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
        for chain in marks.chains:
            points = [at(point) for point in chain]
            _stroke(painter, points, _MEASURE, 1.5)
            for point in points:
                _dot(painter, point, _DOT, _MEASURE)
        for place, text in marks.lengths:
            self._write(painter, at(place), text)
        for place, other, text in marks.angles:
            self._write(painter, at(place) + _away(at(other), at(place), _BESIDE), text)
        painter.restore()

    def _draw_line(self, painter: QPainter, start: QPointF, end: QPointF) -> None:
        _stroke(painter, [start, end], _LINE, 1.5)
        painter.setPen(QPen(_HALO, 1.5))
        painter.setBrush(_LINE)
        for place in (start, end):
            painter.drawRect(QRectF(place.x() - _END, place.y() - _END, 2 * _END, 2 * _END))
        self._write(painter, start + _away(end, start, 14), "A")
        self._write(painter, end + _away(start, end, 14), "B")

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


def _away(start: QPointF, end: QPointF, length: float) -> QPointF:
    """So many pixels in the direction from one point to another."""
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
        """Draw these, and nothing else."""
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
