"""The picture of a point cloud, drawn by the numpy splat, with mouse and keys."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, QTimer
from PySide6.QtGui import (
    QColor,
    QHideEvent,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QWidget

from gui import theme
from ilf.drawing.splat import OrbitCamera, splat

EMPTY_TEXT = "No cloud yet: run the completion, or give camera intrinsics"
MOVING_POINTS = 400_000
"""Larger clouds are thinned to this many points while the view moves."""
REST_MS = 150
"""The whole cloud is drawn when the view has not moved for this long."""

_DIRECTIONS = {"home": (-22.0, 14.0), "front": (0.0, 0.0), "top": (0.0, 90.0), "side": (-90.0, 0.0)}
_ORBIT_STEP = math.radians(5)
_ORBIT_PER_PIXEL = math.radians(0.4)
_PAN_STEP = 30
_ZOOM_STEP = 0.85
_TRIAD = 26

Points = NDArray[np.float32]
Rgb = NDArray[np.uint8]


class CloudCanvas(QWidget):
    """The picture of the cloud, the mouse and the keys."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(160, 120)
        self.setCursor(Qt.CursorShape.OpenHandCursor)
        self.setStatusTip("Drag: orbit. Shift or right drag: pan. Wheel: zoom. Double-click: reset.")
        self.camera = OrbitCamera()
        self.points: Points = np.empty((0, 3), np.float32)
        self.point_size: int | None = None
        self.shaded = True
        self.message = EMPTY_TEXT
        self._colours: Rgb = np.empty((0, 3), np.uint8)
        self._caption = ""
        self._thinned: NDArray[np.intp] | None = None
        self._thin: tuple[Points, Rgb] | None = None
        self._direction: str | None = "home"
        self._picture: QImage | None = None
        self._moving = False
        self._last: QPointF | None = None
        self.rest_timer = QTimer(self, singleShot=True, interval=REST_MS)
        self.rest_timer.timeout.connect(self._redraw)

    def set_points(self, points: Points, reset: bool) -> None:
        """Take new points; their colours follow by `set_colours`."""
        first = not len(self.points)
        self.points = points
        self._thinned = self._thin = None
        if len(points) > MOVING_POINTS:
            # one at random out of each run of points: a fixed stride beats with the image's rows and shows stripes
            starts = np.linspace(0, len(points), MOVING_POINTS, endpoint=False)
            jitter = np.random.default_rng(0).random(MOVING_POINTS) * (len(points) / MOVING_POINTS)
            self._thinned = (starts + jitter).astype(np.intp)
        if reset or first:
            self.look("home")

    def set_colours(self, colours: Rgb, caption: str) -> None:
        """Colours of the points, uint8 (N, 3), and what to say about them."""
        self._colours, self._caption = colours, caption
        self._thin = None
        if self._thinned is not None:
            self._thin = self.points[self._thinned], colours[self._thinned]
        self._redraw()

    def set_drawing(self, point_size: int | None, shaded: bool) -> None:
        """Size of a point in logical pixels (None: by density), and eye-dome lighting."""
        self.point_size, self.shaded = point_size, shaded
        self._redraw()

    def look(self, direction: str) -> None:
        """Show the whole cloud from "home", "front", "top" or "side"; it stays whole when the view is resized."""
        yaw, pitch = (math.radians(angle) for angle in _DIRECTIONS[direction])
        self._direction = direction
        self.camera = OrbitCamera(yaw=yaw, pitch=pitch).fitted(self.points, self.width() / max(self.height(), 1))
        self._redraw()

    def sizeHint(self) -> QSize:
        return QSize(640, 480)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = theme.colours(self.palette())
        if len(self.points):
            if self._picture is None:
                self._picture = self._render()
            painter.drawImage(0, 0, self._picture)
            self._paint_triad(painter, colours)
            self._paint_caption(painter, colours)
        else:
            painter.fillRect(self.rect(), colours.background)
            painter.setPen(colours.muted)
            room = QRectF(self.rect()).adjusted(24, 12, -24, -12)
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.message)
        if self.hasFocus():
            painter.setPen(QPen(colours.accent, 1))
            painter.drawRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._last = event.position()
        self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._last is None:
            return
        moved = event.position() - self._last
        self._last = event.position()
        panning = event.buttons() & (Qt.MouseButton.RightButton | Qt.MouseButton.MiddleButton)
        if panning or event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self._pan(moved.x(), moved.y())
        else:
            self._move(self.camera.orbit(moved.x() * _ORBIT_PER_PIXEL, moved.y() * _ORBIT_PER_PIXEL))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if not event.buttons():
            self._last = None
            self.setCursor(Qt.CursorShape.OpenHandCursor)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._last = event.position()
        self.look("home")

    def wheelEvent(self, event: QWheelEvent) -> None:
        self._move(self.camera.dolly(_ZOOM_STEP ** (event.angleDelta().y() / 120)))
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        arrows: dict[int, tuple[int, int]] = {
            Qt.Key.Key_Left: (-1, 0),
            Qt.Key.Key_Right: (1, 0),
            Qt.Key.Key_Up: (0, -1),
            Qt.Key.Key_Down: (0, 1),
        }
        key = event.key()
        if key in arrows:
            x, y = arrows[key]
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

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._direction is not None:
            self.look(self._direction)
        self._redraw()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.rest_timer.stop()
        self._last = None
        self._redraw()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() in (QEvent.Type.PaletteChange, QEvent.Type.DevicePixelRatioChange):
            self._redraw()

    def _pan(self, dx: float, dy: float) -> None:
        """Move the cloud with the cursor [logical px]: exact at the target's depth."""
        metres = self.camera.distance / self.camera.focal(max(self.height(), 1))
        self._move(self.camera.pan(-dx * metres, -dy * metres))

    def _move(self, camera: OrbitCamera) -> None:
        self.camera = camera
        self._direction = None
        self._moving = True
        self._picture = None
        if self._thin is not None:
            self.rest_timer.start()
        self.update()

    def _redraw(self) -> None:
        """Draw the whole cloud at the next paint."""
        self.rest_timer.stop()
        self._moving = False
        self._picture = None
        self.update()

    def _render(self) -> QImage:
        points, colours = self.points, self._colours
        if self._moving and self._thin is not None:
            points, colours = self._thin
        ratio = self.devicePixelRatioF()
        width, height = max(round(self.width() * ratio), 1), max(round(self.height() * ratio), 1)
        back = theme.colours(self.palette()).background
        size = None if self.point_size is None else max(round(self.point_size * ratio), 1)
        pixels = splat(
            points,
            colours,
            self.camera,
            width,
            height,
            (back.red(), back.green(), back.blue()),
            size,
            shaded=self.shaded,
        )
        borrowed = QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888)
        # the conversion copies, so the image outlives the array
        image = borrowed.convertToFormat(QImage.Format.Format_RGB32)
        image.setDevicePixelRatio(ratio)
        return image

    def _paint_caption(self, painter: QPainter, colours: theme.Colours) -> None:
        room = QRectF(self.rect()).adjusted(12, 6, -12, -8)
        place = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap
        self._paint_backing(painter, colours, painter.boundingRect(room, place, self._caption).adjusted(-6, -2, 6, 2))
        painter.setPen(colours.text)
        painter.drawText(room, place, self._caption)

    @staticmethod
    def _paint_backing(painter: QPainter, colours: theme.Colours, box: QRectF) -> None:
        """Keep what is written over the cloud readable."""
        veil = QColor(colours.background)
        veil.setAlpha(190)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(veil)
        painter.drawRoundedRect(box, 6, 6)
        painter.setBrush(Qt.BrushStyle.NoBrush)

    def _paint_triad(self, painter: QPainter, colours: theme.Colours) -> None:
        """The cloud's axes as the camera sees them, the one that points at the eye last."""
        side = 2 * (_TRIAD + 14)
        box = QRectF(6, self.height() - side - 6, side, side)
        self._paint_backing(painter, colours, box)
        origin = box.center()
        axes = zip("xyz", (colours.error, colours.good, colours.accent), self.camera.rotation().T, strict=True)
        for name, colour, (right, down, forward) in sorted(axes, key=lambda axis: -axis[2][2]):
            painter.setPen(QPen(colour, 2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.drawLine(origin, origin + QPointF(right, down) * _TRIAD)
            if abs(forward) < 0.97:  # an axis seen end on has no room for its letter
                middle = origin + QPointF(right, down) * (_TRIAD + 9)
                painter.drawText(QRectF(middle.x() - 8, middle.y() - 8, 16, 16), Qt.AlignmentFlag.AlignCenter, name)
