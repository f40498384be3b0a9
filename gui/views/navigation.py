"""Where the linked views look, and mouse and keys over them: pan, zoom, cursor, menu, and events for the tool."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum, auto

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, Qt, Signal
from PySide6.QtGui import QContextMenuEvent, QKeyEvent, QMouseEvent, QWheelEvent

from .image_view import ImageView
from .interaction import ARROWS, PointerEvent, PointerHandler, PointerKind

# The transform of the linked views: one centre and one scale for all of them. No Qt.

FIT_MARGIN = 2
"""Screen pixels left free on each side of a fitted frame."""
MIN_ZOOM_SHARE = 0.25
"""Minimum zoom: scale as a share of the fitted one."""
MIN_PIXELS_ACROSS = 8
"""Maximum zoom: image pixels across the view."""


class ViewTransform:
    """Image point in the middle of the views, and scale in screen pixels per image pixel.

    The scale applies to a view of the size given to `set_view`; other views use their `share` of it.

    Parameters
    ----------
    moved : callable
        Called when it looks elsewhere.
    """

    def __init__(self, moved: Callable[[], None]) -> None:
        self._moved = moved
        self.x = self.y = 0.5
        self.scale = 1.0
        self.fitted = True
        self._frame = (1, 1)
        self._view = (1, 1)

    def set_frame(self, width: int, height: int) -> None:
        """Set the frame's size [px] and fit it; `moved` is not called."""
        self._frame = (width, height)
        self._fit()

    def set_view(self, width: int, height: int) -> None:
        """Set the view's size in screen pixels; a fitted frame stays fitted, any other scale is kept. `moved` is not
        called."""
        self._view = (max(width, 1), max(height, 1))
        if self.fitted:
            self._fit()

    @property
    def aspect(self) -> float:
        """Width over height of the frame."""
        return self._frame[0] / self._frame[1]

    @property
    def place(self) -> tuple[float, float, float] | None:
        """What `look_at` takes to look there again; None for the whole frame."""
        return None if self.fitted else (self.x, self.y, self.scale)

    def share(self, width: int, height: int) -> float:
        """Ratio of the fitted scale of a view of this size to that of the view given to `set_view`."""
        return self._fitting(width, height) / self._fitting(*self._view)

    def fit(self) -> None:
        """Show the whole frame."""
        self._fit()
        self._moved()

    def show(self, rows: slice, columns: slice, margin: float = 0.15) -> None:
        """Show a box of the image with a margin, given as a share of the box, on each side."""
        spread = 1 + 2 * margin
        width, height = (max(span.stop - span.start, 1) * spread for span in (columns, rows))
        scale = min(self._view[0] / width, self._view[1] / height)
        self.look_at((columns.start + columns.stop) / 2, (rows.start + rows.stop) / 2, scale)

    def look_at(self, x: float, y: float, scale: float) -> None:
        """Show an image point in the middle, at `scale` screen pixels per image pixel, within the limits."""
        self._put(x, y, self._limited(scale))

    def pan(self, dx: float, dy: float) -> None:
        """Move the image by screen pixels."""
        self._put(self.x - dx / self.scale, self.y - dy / self.scale, self.scale)

    def zoom(self, factor: float, x: float, y: float) -> None:
        """Zoom by a factor; the image point (x, y) keeps its position on the screen."""
        scale = self._limited(self.scale * factor)
        ratio = self.scale / scale
        self._put(x - (x - self.x) * ratio, y - (y - self.y) * ratio, scale)

    def _fit(self) -> None:
        self.x, self.y = self._frame[0] / 2, self._frame[1] / 2
        self.scale = self._fitting(*self._view)
        self.fitted = True

    def _fitting(self, width: int, height: int) -> float:
        room = (max(size - 2 * FIT_MARGIN, 1) for size in (width, height))
        return min(space / size for space, size in zip(room, self._frame, strict=True))

    def _limited(self, scale: float) -> float:
        lowest = self._fitting(*self._view) * MIN_ZOOM_SHARE
        return max(min(scale, max(self._view[0] / MIN_PIXELS_ACROSS, lowest)), lowest)

    def _put(self, x: float, y: float, scale: float) -> None:
        self.x = min(max(x, 0.0), float(self._frame[0]))
        self.y = min(max(y, 0.0), float(self._frame[1]))
        self.scale, self.fitted = scale, False
        self._moved()


# Mouse and keys.

ZOOM_STEP = 1.25
"""Factor per notch of the wheel or press of a key."""
PAN_STEP = 60
"""Screen pixels per press of an arrow key with Alt."""

_ZOOM_KEYS: dict[int, float] = {
    Qt.Key.Key_Plus: ZOOM_STEP,
    Qt.Key.Key_Equal: ZOOM_STEP,
    Qt.Key.Key_Minus: 1 / ZOOM_STEP,
}
_Button = Qt.MouseButton
_Shape = Qt.CursorShape


class _Drag(Enum):
    NONE = auto()
    PAN = auto()
    TOOL = auto()


class Navigation(QObject):
    """Converts events of all views into transform changes, cursor moves and pointer events.

    Signals
    -------
    cursorMoved(object)
        Pixel (x, y) under the pointer, or None off the image; sent when it changes.
    contextMenuRequested(QPoint, float, float)
        Position on the screen and in the image.
    """

    cursorMoved = Signal(object)
    contextMenuRequested = Signal(QPoint, float, float)

    def __init__(self, views: Sequence[ImageView], parent: QObject) -> None:
        super().__init__(parent)
        self.transform = ViewTransform(self.show_place)
        """Where all views look."""
        self._views = views
        self._frame: tuple[int, int] | None = None
        self._handler: PointerHandler | None = None
        self._drag = _Drag.NONE
        self._button = _Button.NoButton
        self._last = QPointF()
        self._pointer: QPointF | None = None
        """Pointer position on the screen; None while it is over no view."""
        self.pixel: tuple[int, int] | None = None
        """Pixel (x, y) under the pointer."""
        self._space = False

    def set_frame(self, size: tuple[int, int] | None) -> None:
        """Set width and height of the frame, and show all of it; None for no frame, which disables the mouse."""
        self._frame = size
        if size is not None:
            self.transform.set_frame(*size)
            for view in self._views:
                view.set_frame_size(*size)
        self._drag = _Drag.NONE
        self.point_at(None)

    def set_handler(self, handler: PointerHandler | None) -> None:
        """Set the receiver of pointer events. A drag in progress ends for the old one without a release."""
        self._handler = handler
        if self._drag is _Drag.TOOL:
            self._drag = _Drag.NONE
        self._show_cursor_shape()

    def handle(self, view: ImageView, event: QEvent) -> bool:
        """Handle an event of a view; False leaves it to Qt."""
        if self._frame is None:
            return False
        match event:
            case QMouseEvent():
                return self._mouse(view, event)
            case QWheelEvent():
                return self._wheel(view, event)
            case QContextMenuEvent():
                return self._context_menu(view, event)
            case QKeyEvent():
                return self._key(event)
        if event.type() == QEvent.Type.Leave:
            self.point_at(None)
            self._send(PointerKind.LEAVE, view, self._last)
        return False

    def _mouse(self, view: ImageView, event: QMouseEvent) -> bool:
        position, moved = event.position(), event.position() - self._last
        self._last, self._pointer = position, event.globalPosition()
        match event.type():
            case QEvent.Type.MouseMove if self._drag is _Drag.PAN:
                self.transform.pan(moved.x() / view.share, moved.y() / view.share)
            case QEvent.Type.MouseMove:
                self._note_pixel(self._pixel_at(view.to_image(position)))
                kind = PointerKind.MOVE if self._drag is _Drag.TOOL else PointerKind.HOVER
                self._send(kind, view, position, event.modifiers())
            case QEvent.Type.MouseButtonRelease:
                self._release(view, event)
            case _:
                self._press(view, event)
        return True

    def _press(self, view: ImageView, event: QMouseEvent) -> None:
        if self._drag is not _Drag.NONE or event.button() not in (_Button.LeftButton, _Button.MiddleButton):
            return
        self._button = event.button()
        self._drag = _Drag.PAN
        if self._button == _Button.LeftButton and not self._space:
            where = view, event.position(), event.modifiers()
            if event.type() == QEvent.Type.MouseButtonDblClick and self._send(PointerKind.DOUBLE, *where):
                self._drag = _Drag.NONE
            elif self._handler is not None and self._send(PointerKind.PRESS, *where) is not False:
                self._drag = _Drag.TOOL
        self._show_cursor_shape()

    def _release(self, view: ImageView, event: QMouseEvent) -> None:
        if self._drag is _Drag.NONE or event.button() != self._button:
            return
        drag, self._drag = self._drag, _Drag.NONE
        if drag is _Drag.TOOL:
            self._send(PointerKind.RELEASE, view, event.position(), event.modifiers())
        self._show_cursor_shape()

    def _wheel(self, view: ImageView, event: QWheelEvent) -> bool:
        # Alt turns the wheel sideways on some systems
        turn = event.angleDelta().y() or event.angleDelta().x()
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier and turn:
            steps = int(math.copysign(max(abs(turn) // 120, 1), turn))
            if self._send(PointerKind.WHEEL, view, event.position(), event.modifiers(), steps):
                return True
        self._pointer = event.globalPosition()
        point = view.to_image(event.position())
        self.transform.zoom(ZOOM_STEP ** (turn / 120), point.x(), point.y())
        return True

    def _context_menu(self, view: ImageView, event: QContextMenuEvent) -> bool:
        if self._drag is _Drag.NONE:
            point = view.to_image(QPointF(event.pos()))
            self.contextMenuRequested.emit(event.globalPos(), point.x(), point.y())
        return True

    def _key(self, event: QKeyEvent) -> bool:
        key, modifiers = event.key(), event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        if event.type() != QEvent.Type.KeyPress:
            return False
        if key in ARROWS and modifiers == Qt.KeyboardModifier.AltModifier:
            right, down = ARROWS[key]
            self.transform.pan(-PAN_STEP * right, -PAN_STEP * down)
            return True
        if key in _ZOOM_KEYS and not modifiers & ~Qt.KeyboardModifier.ShiftModifier:
            self.transform.zoom(_ZOOM_KEYS[key], self.transform.x, self.transform.y)
            return True
        return False

    def _send(
        self,
        kind: PointerKind,
        view: ImageView,
        position: QPointF,
        modifiers: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier,
        steps: int = 0,
    ) -> bool | None:
        if self._handler is None:
            return None
        point = view.to_image(position)
        return self._handler(
            PointerEvent(
                kind,
                point.x(),
                point.y(),
                shift=bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
                ctrl=bool(modifiers & Qt.KeyboardModifier.ControlModifier),
                alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
                pixel=1 / view.transform.m11(),
                steps=steps,
            )
        )

    def _pixel_at(self, point: QPointF) -> tuple[int, int] | None:
        if self._frame is None:
            return None
        width, height = self._frame
        x, y = math.floor(point.x()), math.floor(point.y())
        return (x, y) if 0 <= x < width and 0 <= y < height else None

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y), wherever the mouse is until it moves; None hides it."""
        self._pointer = None
        self._note_pixel(pixel)

    def _note_pixel(self, pixel: tuple[int, int] | None) -> None:
        if pixel != self.pixel:
            self.pixel = pixel
            self.cursorMoved.emit(pixel)

    def show_place(self) -> None:
        """Pan and zoom all views, and update the pixel under the pointer."""
        for view in self._views:
            view.show_place(self.transform.x, self.transform.y, self.transform.scale)
        if self._pointer is None:
            return
        shown = (view for view in self._views if view.isVisible())
        places = ((view, view.viewport().mapFromGlobal(self._pointer)) for view in shown)
        there = ((view, place) for view, place in places if view.viewport().rect().contains(place.toPoint()))
        self._note_pixel(next((self._pixel_at(view.to_image(place)) for view, place in there), None))

    def set_space(self, held: bool) -> None:
        """Set whether the space key is held anywhere: the left button then pans."""
        self._space = held
        self._show_cursor_shape()

    def _show_cursor_shape(self) -> None:
        if self._drag is _Drag.PAN:
            shape = _Shape.ClosedHandCursor
        elif self._space:
            shape = _Shape.OpenHandCursor
        else:
            shape = _Shape.ArrowCursor if self._handler is None else _Shape.CrossCursor
        for view in self._views:
            view.viewport().setCursor(shape)
