"""The canvas of a point cloud, with mouse and keys: coarse while it moves, full at rest."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QEnterEvent,
    QFontMetricsF,
    QHideEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QShowEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from ilf.drawing.clouds import NEAR, OrbitCamera, Sight

from ...base import theme
from ...base.theme import Colours
from ..drawings import write_on_plate
from ..interaction import ARROWS
from .drawing import CloudDrawing
from .scene import Scene

# Overlays of a cloud: axes, mark, lines.

_MARGIN = 6
_ARM = 26
_BOX = 2 * (_ARM + 14)
_RING = 6
_DOT = 2.5
_VEIL = 190


def paint_axes(painter: QPainter, camera: OrbitCamera, colours: Colours, bottom: float) -> None:
    """Draw the cloud's axes at the lower left, from back to front."""
    box = QRectF(_MARGIN, bottom - _BOX - _MARGIN, _BOX, _BOX)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(theme.faded(colours.background, _VEIL))
    painter.drawRoundedRect(box, 6, 6)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    origin = box.center()
    axes = zip("xyz", (colours.error, colours.good, colours.accent), camera.rotation().T, strict=True)
    for name, colour, (right, down, forward) in sorted(axes, key=lambda axis: -axis[2][2]):
        painter.setPen(QPen(colour, 2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawLine(origin, origin + QPointF(right, down) * _ARM)
        if abs(forward) < 0.97:  # an axis towards the camera has no room for its letter
            middle = origin + QPointF(right, down) * (_ARM + 9)
            painter.drawText(QRectF(middle.x() - 8, middle.y() - 8, 16, 16), Qt.AlignmentFlag.AlignCenter, name)


def paint_mark(painter: QPainter, place: QPointF) -> None:
    """Draw a ring around the point under the pointer, here or in the images; visible on light and dark."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, width in ((QColor(0, 0, 0, 200), 3.5), (QColor(255, 255, 255), 1.5)):
        painter.setPen(QPen(colour, width))
        painter.drawEllipse(place, _RING, _RING)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            painter.drawLine(place + QPointF(dx, dy) * _RING, place + QPointF(dx, dy) * (_RING + 5))


def paint_line(painter: QPainter, places: Sequence[QPointF | None]) -> None:
    """Draw a line through positions, with a dot at each; segments to None are omitted."""
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


MOVES = "Drag: rotate | Shift+drag: pan | wheel: zoom"
HINT = f"{MOVES} | click: select block | double-click: centre | R: reset | hold X: raw depth"
EMPTY_TEXT = "No point cloud: open a frame with known camera intrinsics"
DIRECTIONS = {
    "home": ("&Whole cloud", "Show the whole cloud (R, Home, double-click beside it)", -22.0, 14.0),
    "front": ("From the &camera", "View along the axis of the depth camera", 0.0, 0.0),
    "top": ("From &above", "View from above", 0.0, 90.0),
    "side": ("From the &right", "View from the right", -90.0, 0.0),
}
"""Directions of view: text and hint in the menu, yaw and pitch [degrees]."""
_ORBIT_STEP = math.radians(5)
_ORBIT_PER_PIXEL = math.radians(0.4)
_PAN_STEP = 30
_ZOOM_STEP = 0.85
_DRAG_THRESHOLD = 4
"""Distance [px] beyond which a press is a drag."""
_HIT_RADIUS = 4
"""Distance [px] within which the pointer hits a point."""


class CloudCanvas(QWidget):
    """Widget that draws the cloud and handles mouse and keys.

    Signals
    -------
    hovered(object)
        The pixel (x, y) of the frame whose point is under the pointer, or None; sent when it changes.
    picked(int, int, bool)
        x and y of the pixel whose point was clicked, and whether Ctrl was held.
    hover_changed(bool)
        The pointer entered or left.
    """

    hovered = Signal(object)
    picked = Signal(int, int, bool)
    hover_changed = Signal(bool)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setMouseTracking(True)
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        self.setAccessibleName("Point cloud")
        self.setAccessibleDescription(HINT)
        self.camera = OrbitCamera()
        self.point_size: int | None = None
        self.shaded = True
        self.depths = (-math.inf, math.inf)
        self.message = EMPTY_TEXT
        self._direction: str | None = "home"
        self._last: QPointF | None = None
        self._pressed: QPointF | None = None
        self._pixel: tuple[int, int] | None = None
        self._marked: tuple[int, int] | None = None
        self._lines: Sequence[Sequence[tuple[float, float]]] = ()
        self._texts: Sequence[str] = ()
        self.drawing = CloudDrawing(self)
        self.drawing.ready.connect(self.update)

    # what is shown

    @property
    def scene(self) -> Scene:
        """The scene shown."""
        return self.drawing.scene

    def set_scene(self, scene: Scene, reset: bool) -> None:
        """Show another cloud; with `reset`, fit all of it into the view."""
        self.drawing.set_scene(scene)
        if reset:
            self.look("home")
        else:
            self._redraw()

    def set_message(self, text: str) -> None:
        """Show a text in place of a cloud."""
        self.message = text
        self.drawing.set_scene(Scene())
        self._set_pixel(None)
        self.update()

    def set_point_size(self, size: int | None) -> None:
        """Set the point size in logical pixels (None: from density)."""
        self.point_size = size
        self._redraw()

    def set_shaded(self, on: bool) -> None:
        """Draw with eye-dome lighting, or without."""
        self.shaded = on
        self._redraw()

    def set_depths(self, low: float, high: float) -> None:
        """Draw only points with depth [m] between these two."""
        if (low, high) != self.depths:
            self.depths = low, high
            self._redraw(moving=True)

    def look(self, direction: str) -> None:
        """Show the whole cloud from "home", "front", "top" or "side"; it stays whole when the view is resized."""
        yaw, pitch = map(math.radians, DIRECTIONS[direction][2:])
        self._direction = direction
        self.camera = OrbitCamera(yaw=yaw, pitch=pitch).fitted(self.scene.points, self.width() / max(self.height(), 1))
        self._redraw(moving=True)

    def mark(self, pixel: tuple[int, int] | None) -> None:
        """Mark the point of a pixel (x, y) of the frame; None for none."""
        if pixel != self._marked:
            self._marked = pixel
            self.update()

    def set_lines(self, lines: Sequence[Sequence[tuple[float, float]]], texts: Sequence[str]) -> None:
        """Draw lines between the points of image positions, with a text at the middle of each segment."""
        if (lines, texts) != (self._lines, self._texts):
            self._lines, self._texts = lines, texts
            self.update()

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    # painting

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = theme.colours(self.palette())
        if len(self.scene):
            image = self.drawing.image()
            if image is not None:
                painter.drawImage(QRectF(self.rect()), image)
            paint_axes(painter, self.camera, colours, self.height())
            lines = [[self._place_of((int(x), int(y))) for x, y in line] for line in self._lines]
            for line in lines:
                paint_line(painter, line)
            stretches = (ends for line in lines for ends in itertools.pairwise(line))
            for (one, other), text in zip(stretches, self._texts, strict=False):
                if one is not None and other is not None:
                    write_on_plate(painter, (one + other) / 2, text, QFontMetricsF(self.font()))
            marked = None if self._marked is None else self._place_of(self._marked)
            if marked is not None:
                paint_mark(painter, marked)
        else:
            painter.fillRect(self.rect(), colours.background)
            painter.setPen(colours.muted)
            room = QRectF(self.rect()).adjusted(24, 12, -24, -12)
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.message)
        if self.hasFocus():
            painter.setPen(QPen(colours.accent, 1))
            painter.drawRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5))

    def _place_of(self, pixel: tuple[int, int]) -> QPointF | None:
        """Widget position of the point of a pixel; None if it has none or lies behind the camera."""
        index = self.scene.index_of(pixel)
        if index is None:
            return None
        x, y, before = self.camera.project(self.scene.points[index : index + 1], self.width(), self.height())[0]
        return QPointF(x, y) if before > NEAR else None

    def _look(self) -> Sight:
        """The current look."""
        ratio = self.devicePixelRatioF()
        back = theme.colours(self.palette()).background
        return Sight(
            self.camera,
            max(round(self.width() * ratio), 1),
            max(round(self.height() * ratio), 1),
            (back.red(), back.green(), back.blue()),
            None if self.point_size is None else max(round(self.point_size * ratio), 1),
            self.shaded,
            self.depths,
        )

    def _redraw(self, moving: bool = False) -> None:
        self.drawing.look(self._look(), moving)
        self.update()

    def _move(self, camera: OrbitCamera) -> None:
        self.camera = camera
        self._direction = None
        self._redraw(moving=True)

    # the point under the pointer

    def _pixel_at(self, position: QPointF) -> tuple[int, int] | None:
        """Pixel (x, y) of the visible point at a position of the widget, or near it."""
        ratio = self.devicePixelRatioF()
        return self.drawing.pixel_at(position.x() * ratio, position.y() * ratio, _HIT_RADIUS * ratio)

    def _set_pixel(self, pixel: tuple[int, int] | None) -> None:
        if pixel != self._pixel:
            self._pixel = pixel
            self.mark(pixel)
            self.hovered.emit(pixel)

    # mouse and keys

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._last = event.position()
        self._pressed = event.position() if event.button() == Qt.MouseButton.LeftButton else None
        self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._last is None:
            self._set_pixel(self._pixel_at(event.position()))
            return
        if self._pressed is not None and (event.position() - self._pressed).manhattanLength() <= _DRAG_THRESHOLD:
            return
        self._pressed = None
        moved = event.position() - self._last
        self._last = event.position()
        panning = event.buttons() & (Qt.MouseButton.RightButton | Qt.MouseButton.MiddleButton)
        if panning or event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self._pan(moved.x(), moved.y())
        else:
            self._move(self.camera.orbit(moved.x() * _ORBIT_PER_PIXEL, moved.y() * _ORBIT_PER_PIXEL))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if event.buttons():
            return
        pressed, self._pressed, self._last = self._pressed, None, None
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        pixel = None if pressed is None else self._pixel_at(pressed)
        if pixel is not None:
            self.picked.emit(*pixel, bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Set the centre of rotation to the double-clicked point; beside the cloud, show all of it."""
        self._last = event.position()
        pixel = self._pixel_at(event.position())
        index = None if pixel is None else self.scene.index_of(pixel)
        if index is None:
            self.look("home")
        else:
            x, y, z = (float(value) for value in self.scene.points[index])
            self._move(replace(self.camera, target=(x, y, z)))

    def wheelEvent(self, event: QWheelEvent) -> None:
        self._move(self.camera.dolly(_ZOOM_STEP ** (event.angleDelta().y() / 120)))
        event.accept()

    def enterEvent(self, event: QEnterEvent) -> None:
        super().enterEvent(event)
        self.hover_changed.emit(True)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self._set_pixel(None)
        self.hover_changed.emit(False)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key = event.key()
        if key in ARROWS:
            x, y = ARROWS[key]
            if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
                self._pan(x * _PAN_STEP, y * _PAN_STEP)
            else:
                self._move(self.camera.orbit(x * _ORBIT_STEP, y * _ORBIT_STEP))
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Equal):
            self._move(self.camera.dolly(_ZOOM_STEP))
        elif key == Qt.Key.Key_Minus:
            self._move(self.camera.dolly(1 / _ZOOM_STEP))
        elif key in (Qt.Key.Key_R, Qt.Key.Key_Home) and not event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            self.look("home")
        else:
            super().keyPressEvent(event)

    def _pan(self, dx: float, dy: float) -> None:
        """Pan with the cursor [logical px]; exact at the target's depth."""
        metres = self.camera.metres_per_pixel(max(self.height(), 1))
        self._move(self.camera.pan(-dx * metres, -dy * metres))

    # events of the widget

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._direction is not None:
            self.look(self._direction)
        self._redraw(moving=True)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.drawing.resume()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.drawing.pause()
        self._last = self._pressed = None
        self._set_pixel(None)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.DevicePixelRatioChange):
            self._redraw(moving=True)
