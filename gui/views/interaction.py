"""Pointer events for tools, in image coordinates, the same in every view; and the preview of a tool."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from itertools import pairwise
from statistics import median

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from .scene_items import ViewItem

ARROWS: dict[int, tuple[int, int]] = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Up: (0, -1),
    Qt.Key.Key_Down: (0, 1),
}
"""Arrow keys -> their directions: right and down."""


class PointerKind(Enum):
    """Kind of a pointer event."""

    PRESS = auto()
    MOVE = auto()
    """Moved while the left button, pressed for the tool, is held."""
    RELEASE = auto()
    HOVER = auto()
    LEAVE = auto()
    DOUBLE = auto()
    WHEEL = auto()
    """The wheel was turned while Ctrl was held."""


@dataclass(frozen=True)
class PointerEvent:
    """One pointer event over an image view.

    Parameters
    ----------
    kind : PointerKind
        What happened.
    x, y : float
        Position in image coordinates: the pixel in row r, column c covers x in [c, c + 1), y in [r, r + 1).
        May lie outside the image.
    shift, ctrl, alt : bool
        Modifier keys held.
    pixel : float
        Image pixels per pixel of the screen.
    steps : int
        Wheel steps; positive: away from the user.
    """

    kind: PointerKind
    x: float
    y: float
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    pixel: float = 1.0
    steps: int = 0

    @property
    def opposite(self) -> bool:
        """Whether a tool's opposite is meant, such as to take away: Ctrl, or Alt where the desktop does not use it."""
        return self.alt or (self.ctrl and self.kind is not PointerKind.WHEEL)


PointerHandler = Callable[[PointerEvent], "bool | None"]
"""Handles pointer events. False for PRESS: rejected, pan instead. True for DOUBLE: handled, send no PRESS for
it. True for WHEEL: handled, do not zoom."""


# The preview of a tool, drawn over the views.

_LINE, _HALO, _SHADE = QColor(255, 221, 51), QColor(0, 0, 0, 200), QColor(0, 0, 0, 110)
_WIDTH = 2.0
_HANDLE = 2.0, 4.0
"""Half the side of a handle [screen px], minimum and maximum."""


@dataclass(frozen=True, eq=False)
class Preview:
    """Lines, corners and an area, in image coordinates.

    Attributes
    ----------
    line : QPainterPath
        Drawn bright on dark, visible on any picture.
    corners : sequence of (x, y)
        Drawn as small squares, of one size on the screen unless they would hide the line.
    dashed : bool
        Whether the line is only a suggestion.
    area : QPainterPath, optional
        Shaded and hatched.
    line_preview : QPainterPath, optional
        Predicted result, drawn dashed beside the line.
    """

    line: QPainterPath
    corners: Sequence[tuple[float, float]] = ()
    dashed: bool = False
    area: QPainterPath | None = None
    line_preview: QPainterPath | None = None


class PreviewItem(ViewItem):
    """Draws a preview; the widths of its lines are screen pixels at every zoom."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.preview: Preview | None = None

    def set_preview(self, preview: Preview | None) -> None:
        """Draw another preview; None for nothing."""
        self.preview = preview
        if preview is None:
            self.set_extent(None)
            return
        extent = preview.line.controlPointRect()
        for path in (preview.area, preview.line_preview):
            if path is not None:
                extent = extent.united(path.controlPointRect())
        for x, y in preview.corners:
            extent = extent.united(QRectF(x, y, 1e-6, 1e-6))
        self.set_extent(extent, _WIDTH + _HANDLE[1] + 3)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        preview = self.preview
        if preview is None:
            return
        if preview.area is not None:
            painter.fillPath(preview.area, _SHADE)
            painter.fillPath(preview.area, QBrush(_LINE, Qt.BrushStyle.BDiagPattern))
        # straight lines along the pixels' edges are clearer without; others are not
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if preview.line_preview is not None:
            _draw(painter, preview.line_preview, dashed=True)
        _draw(painter, preview.line, preview.dashed)
        self._draw_corners(painter, preview)

    def _draw_corners(self, painter: QPainter, preview: Preview) -> None:
        half = self._half_handle(preview.corners) * self._pixel_size
        painter.setPen(pg.mkPen(_HALO, width=1.5))
        painter.setBrush(_LINE)
        for x, y in preview.corners:
            painter.drawRect(QRectF(QPointF(x - half, y - half), QPointF(x + half, y + half)))
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _half_handle(self, corners: Sequence[tuple[float, float]]) -> float:
        """Half the side of a handle [screen px]: smaller where most corners are close together, as in a small view."""
        least, most = _HANDLE
        if len(corners) < 2:
            return most
        apart = median(math.dist(one, other) for one, other in pairwise(corners)) / self._pixel_size
        return min(max(apart / 5, least), most)


def _draw(painter: QPainter, path: QPainterPath, dashed: bool) -> None:
    for colour, width in ((_HALO, _WIDTH + 2), (_LINE, _WIDTH)):
        pen = pg.mkPen(colour, width=width, dash=[4, 3] if dashed and colour is _LINE else None)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.drawPath(path)
