"""What is drawn over a cloud: axes, scale bar, mark."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from gui.theme import Colours
from ilf.drawing.orbit import OrbitCamera

_MARGIN = 6
_ARM = 26
_BOX = 2 * (_ARM + 14)
_LONGEST = 150
"""Of the scale bar [px]."""
_TICK = 4
_RING = 6
_DOT = 2.5
_VEIL = 190


def paint_axes(painter: QPainter, camera: OrbitCamera, colours: Colours, bottom: float) -> None:
    """The cloud's axes as the camera sees them, at the lower left, the one that points at the eye last."""
    box = QRectF(_MARGIN, bottom - _BOX - _MARGIN, _BOX, _BOX)
    _paint_backing(painter, colours, box)
    origin = box.center()
    axes = zip("xyz", (colours.error, colours.good, colours.accent), camera.rotation().T, strict=True)
    for name, colour, (right, down, forward) in sorted(axes, key=lambda axis: -axis[2][2]):
        painter.setPen(QPen(colour, 2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawLine(origin, origin + QPointF(right, down) * _ARM)
        if abs(forward) < 0.97:  # an axis seen end on has no room for its letter
            middle = origin + QPointF(right, down) * (_ARM + 9)
            painter.drawText(QRectF(middle.x() - 8, middle.y() - 8, 16, 16), Qt.AlignmentFlag.AlignCenter, name)


def paint_scale(painter: QPainter, metres_per_pixel: float, colours: Colours, bottom: float) -> None:
    """A bar of a round length, at the right of the axes; it holds at the depth of the middle of the view."""
    length = round_length(metres_per_pixel * _LONGEST)
    pixels = length / metres_per_pixel
    text = length_text(length)
    metrics = painter.fontMetrics()
    width = max(pixels, metrics.horizontalAdvance(text)) + 2 * _MARGIN
    height = metrics.height() + _TICK + 2 * _MARGIN
    box = QRectF(2 * _MARGIN + _BOX, bottom - height - _MARGIN, width, height)
    _paint_backing(painter, colours, box)
    painter.setPen(QPen(colours.text, 1))
    y, left = box.bottom() - _MARGIN, box.center().x() - pixels / 2
    ends = QPointF(left, y), QPointF(left + pixels, y)
    painter.drawLine(*ends)
    for end in ends:
        painter.drawLine(end, end - QPointF(0, _TICK))
    painter.drawText(
        box.adjusted(0, _MARGIN / 2, 0, 0), Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop, text
    )


def paint_mark(painter: QPainter, place: QPointF) -> None:
    """A ring around the point that the pointer is at, here or in the images; it is seen on light and on dark."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, width in ((QColor(0, 0, 0, 200), 3.5), (QColor(255, 255, 255), 1.5)):
        painter.setPen(QPen(colour, width))
        painter.drawEllipse(place, _RING, _RING)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            painter.drawLine(place + QPointF(dx, dy) * _RING, place + QPointF(dx, dy) * (_RING + 5))


def paint_line(painter: QPainter, places: Sequence[QPointF | None]) -> None:
    """A line through places, with a dot at each; what leads to one that is not there is left out."""
    painter.setBrush(QColor(255, 255, 255))
    for colour, width in ((QColor(0, 0, 0, 200), 4.0), (QColor(255, 255, 255), 2.0)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        for one, other in itertools.pairwise(places):
            if one is not None and other is not None:
                painter.drawLine(one, other)
        for place in places:
            if place is not None:
                painter.drawEllipse(place, _DOT, _DOT)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def paint_text(painter: QPainter, middle: QPointF, text: str, colours: Colours) -> None:
    """A text about a place."""
    metrics = painter.fontMetrics()
    box = QRectF(0, 0, metrics.horizontalAdvance(text) + _MARGIN, metrics.height())
    box.moveCenter(middle)
    _paint_backing(painter, colours, box)
    painter.setPen(colours.text)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def round_length(most: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length [m]."""
    power = 10.0 ** math.floor(math.log10(most))
    return next(step * power for step in (5, 2, 1) if step * power <= most * (1 + 1e-9))


def length_text(length: float) -> str:
    """A round length [m] in the unit in which it is a small number."""
    for unit, metres in (("km", 1000.0), ("m", 1.0), ("cm", 0.01)):
        if length >= metres * (1 - 1e-9):
            return f"{length / metres:.4g} {unit}"
    return f"{1000 * length:.4g} mm"


def _paint_backing(painter: QPainter, colours: Colours, box: QRectF) -> None:
    """Keep what is written over the cloud readable."""
    veil = QColor(colours.background)
    veil.setAlpha(_VEIL)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(veil)
    painter.drawRoundedRect(box, 6, 6)
    painter.setBrush(Qt.BrushStyle.NoBrush)
