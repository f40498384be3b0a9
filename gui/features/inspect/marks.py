"""Profile line, rectangle and measurements drawn over the views."""

from __future__ import annotations

import math
from dataclasses import dataclass

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPolygonF

from ilf.data.label_map import Box
from ilf.evaluation.measuring import Line
from ilf.project.frame_state import Point

from ...views.drawings import Drawing, write_on_plate
from ...views.image_view import ImageView

_HEIGHT = 5.8
"""Z value: above the blocks' lines and names, below a tool's preview."""
_LINE, _REGION, _MEASURE = QColor(96, 220, 255), QColor(255, 255, 255), QColor(255, 176, 64)
_HALO = QColor(0, 0, 0, 190)
_WIDTH, _POINT, _PAD = 1.5, 4.0, 3.0
_BESIDE = 14.0
"""Distance of the names of a line's ends from these [px]."""


@dataclass(frozen=True)
class MarkedLine:
    """A line with marked points, in image coordinates; a single point is only marked."""

    points: tuple[Point, ...]
    colour: QColor
    style: Qt.PenStyle = Qt.PenStyle.SolidLine
    square: bool = False
    """Whether the points are squares, which can be dragged at any time; else dots."""


@dataclass(frozen=True)
class Text:
    """A text at a place in image coordinates, or beside it: in the direction away from another place."""

    place: Point
    text: str
    away_from: Point | None = None


Marks = tuple[MarkedLine | Text, ...]


def profile_marks(line: Line | None, place: Point | None) -> Marks:
    """Marks of the profile line from A to B, and of a place on it."""
    if line is None:
        return ()
    start, end = line
    ends = Text(start, "A", away_from=end), Text(end, "B", away_from=start)
    return MarkedLine(line, _LINE, square=True), *([MarkedLine((place,), _LINE)] if place is not None else []), *ends


def region_marks(region: Box | None) -> Marks:
    """Marks of the rectangle."""
    if region is None:
        return ()
    (top, bottom), (left, right) = ((side.start, side.stop) for side in region)
    corners = (left, top), (right, top), (right, bottom), (left, bottom), (left, top)
    return (MarkedLine(corners, _REGION, Qt.PenStyle.DashLine, square=True),)


def measurement_marks(line: Line, text: str) -> Marks:
    """Marks of a measurement, with its length at the middle."""
    (x0, y0), (x1, y1) = line
    return MarkedLine(line, _MEASURE), Text(((x0 + x1) / 2, (y0 + y1) / 2), text)


class MarksItem(Drawing):
    """Draws marks in a view with lines, points and texts of constant size on the screen."""

    def __init__(self, view: ImageView) -> None:
        super().__init__(_HEIGHT)
        view.add(self)
        self.marks: Marks = ()
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)

    def show_marks(self, marks: Marks) -> None:
        """Draw these marks only."""
        if marks == self.marks:
            return
        self.marks = marks
        points = [QPointF(*point) for one in marks if isinstance(one, MarkedLine) for point in one.points]
        metrics, texts = QFontMetricsF(self._font), [one for one in marks if isinstance(one, Text)]
        widest = max((metrics.horizontalAdvance(one.text) for one in texts), default=0.0)
        reach = _BESIDE + max(widest, metrics.height()) / 2 + 2 * _PAD
        self.set_extent(QPolygonF(points).boundingRect() if points else None, reach)

    def paint(self, painter: QPainter, pixel: float) -> None:
        to_screen, metrics = painter.worldTransform(), QFontMetricsF(self._font)
        painter.resetTransform()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(self._font)
        for one in self.marks:
            if isinstance(one, MarkedLine):
                _draw(painter, one, [to_screen.map(QPointF(*point)) for point in one.points])
                continue
            place = to_screen.map(QPointF(*one.place))
            if one.away_from is not None:
                way = place - to_screen.map(QPointF(*one.away_from))
                place += way * (_BESIDE / max(math.hypot(way.x(), way.y()), 1e-6))
            write_on_plate(painter, place, one.text, metrics)


def _draw(painter: QPainter, stroke: MarkedLine, points: list[QPointF]) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in (QPen(_HALO, _WIDTH + 2), QPen(stroke.colour, _WIDTH, stroke.style)):
        painter.setPen(pen)
        painter.drawPolyline(points)
    painter.setPen(QPen(_HALO, _WIDTH))
    painter.setBrush(stroke.colour)
    for point in points:
        if stroke.square:
            painter.drawRect(QRectF(point.x() - _POINT, point.y() - _POINT, 2 * _POINT, 2 * _POINT))
        else:
            painter.drawEllipse(point, _POINT, _POINT)
