"""Profile line, rectangle and measurements drawn over the views."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QPointF
from PySide6.QtGui import QColor, QPainterPath, QPolygonF

from ilf.data.blocks import Box
from ilf.evaluation.measuring import Line
from ilf.project.frame_state import Point

from ...tools.base import line_path
from ...views.drawings import Names, PreviewDrawing
from ...views.image_view import ImageView
from ...views.interaction import Preview

_HEIGHT = 5.8
"""Z value: above the blocks' lines and names, below a tool's preview."""
_PROFILE, _REGION, _MEASURE = QColor(96, 220, 255), QColor(255, 255, 255), QColor(255, 176, 64)
_BEYOND = 0.05
"""Distance of the names of a line's ends from these, as a share of its length."""


class Marks:
    """What is drawn over a view."""

    def __init__(self, view: ImageView) -> None:
        self.region, self.profile, self.measured = (
            PreviewDrawing(_HEIGHT, colour) for colour in (_REGION, _PROFILE, _MEASURE)
        )
        self.names = Names(_HEIGHT)
        for drawing in (self.region, self.profile, self.measured, self.names):
            view.add(drawing)

    def show(
        self, line: Line | None, place: Point | None, region: Box | None, measured: Sequence[Line], texts: Sequence[str]
    ) -> None:
        """Show the profile line from A to B with a place on it, the rectangle, and measurements with a text each."""
        names: list[tuple[str, Point]] = []
        if line is not None:
            (x0, y0), (x1, y1) = line
            away = _BEYOND * (x1 - x0), _BEYOND * (y1 - y0)
            names += [("A", (x0 - away[0], y0 - away[1])), ("B", (x1 + away[0], y1 + away[1]))]
            places = () if place is None else (place,)
            self.profile.set_preview(Preview(line_path(line), (*line, *places)))
        else:
            self.profile.set_preview(None)
        if region is not None:
            (top, bottom), (left, right) = ((side.start, side.stop) for side in region)
            corners = (left, top), (right, top), (right, bottom), (left, bottom)
            self.region.set_preview(Preview(line_path(corners, closed=True), corners, dashed=True))
        else:
            self.region.set_preview(None)
        path = QPainterPath()
        for ends, text in zip(measured, texts, strict=True):
            path.addPath(line_path(ends))
            names.append((text, ((ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2)))
        self.measured.set_preview(Preview(path, [point for ends in measured for point in ends]) if measured else None)
        around = QPolygonF([QPointF(*point) for _, point in names]).boundingRect()
        points = {number: (*point, math.inf) for number, (_, point) in enumerate(names)}
        self.names.set_names({number: text for number, (text, _) in enumerate(names)}, points, around)
