"""View of one picture in image coordinates, with overlays; no application logic."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QLineF, QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPaintEvent, QResizeEvent, QTransform
from PySide6.QtWidgets import QAbstractScrollArea

from ilf.data.label_map import Box
from ilf.drawing.blocks import InnerPoint

from ..base import theme
from .drawings import Drawing, HaloPath, Names, PreviewDrawing
from .pixel_items import PixelItem, Pixels, PointsItem, ScreenItem

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
    """

    def __init__(self) -> None:
        self.x = self.y = 0.5
        self.scale = 1.0
        self.fitted = True
        self._frame = (1, 1)
        self._view = (1, 1)

    def set_frame(self, width: int, height: int) -> None:
        """Set the frame's size [px] and fit it."""
        self._frame = (width, height)
        self.fit()

    def set_view(self, width: int, height: int) -> None:
        """Set the view's size in screen pixels; a fitted frame stays fitted, any other scale is kept."""
        self._view = (max(width, 1), max(height, 1))
        if self.fitted:
            self.fit()

    @property
    def aspect(self) -> float:
        """Width over height of the frame."""
        return self._frame[0] / self._frame[1]

    def share(self, width: int, height: int) -> float:
        """Ratio of the fitted scale of a view of this size to that of the view given to `set_view`."""
        return self._fitting(width, height) / self._fitting(*self._view)

    def fit(self) -> None:
        """Show the whole frame."""
        self.x, self.y = self._frame[0] / 2, self._frame[1] / 2
        self.scale = self._fitting(*self._view)
        self.fitted = True

    def show(self, left: float, top: float, right: float, bottom: float, margin: float = 0.15) -> None:
        """Show a box of the image with a margin, given as a share of the box, on each side."""
        self.x, self.y = (left + right) / 2, (top + bottom) / 2
        spread = 1 + 2 * margin
        width, height = max(right - left, 1) * spread, max(bottom - top, 1) * spread
        self.set_scale(min(self._view[0] / width, self._view[1] / height))

    def look_at(self, x: float, y: float, scale: float) -> None:
        """Show an image point in the middle, at `scale` screen pixels per image pixel, within the limits."""
        self.x, self.y = x, y
        self.set_scale(scale)
        self._keep_in_frame()

    def pan(self, dx: float, dy: float) -> None:
        """Move the image by screen pixels."""
        self.x -= dx / self.scale
        self.y -= dy / self.scale
        self._keep_in_frame()

    def zoom(self, factor: float, x: float, y: float) -> None:
        """Zoom by a factor; the image point (x, y) keeps its position on the screen."""
        before = self.scale
        self.set_scale(before * factor)
        ratio = before / self.scale
        self.x, self.y = x - (x - self.x) * ratio, y - (y - self.y) * ratio
        self._keep_in_frame()

    def set_scale(self, scale: float) -> None:
        """Show `scale` screen pixels per image pixel around the current centre, within the limits."""
        lowest = self._fitting(*self._view) * MIN_ZOOM_SHARE
        self.scale = max(min(scale, max(self._view[0] / MIN_PIXELS_ACROSS, lowest)), lowest)
        self.fitted = False

    def _fitting(self, width: int, height: int) -> float:
        room = (max(size - 2 * FIT_MARGIN, 1) for size in (width, height))
        return min(space / size for space, size in zip(room, self._frame, strict=True))

    def _keep_in_frame(self) -> None:
        self.x = min(max(self.x, 0.0), float(self._frame[0]))
        self.y = min(max(self.y, 0.0), float(self._frame[1]))
        self.fitted = False


FOCUS_WIDTH = 2
_CROSS_GAP = 9
_MIN_SHARE_FOR_NAMES = 0.5


class ImageView(QAbstractScrollArea):
    """A picture in image coordinates, lines and stripes over it, a tool's preview and the crosshair.

    Parameters
    ----------
    on_event : callable
        Receives (view, event) for every mouse, wheel, key and leave event; True if it handled the event.
    """

    resized = Signal()
    is_of_frame = True
    """Whether the picture has the frame's pixels; any other one is alone in the view, and has no pan and zoom."""

    _EVENTS = frozenset(
        {
            QEvent.Type.MouseButtonPress,
            QEvent.Type.MouseButtonDblClick,
            QEvent.Type.MouseButtonRelease,
            QEvent.Type.MouseMove,
            QEvent.Type.Wheel,
            QEvent.Type.Leave,
            QEvent.Type.ContextMenu,
        }
    )
    _KEYS = frozenset({QEvent.Type.KeyPress, QEvent.Type.KeyRelease})

    def __init__(self, on_event: Callable[[ImageView, QEvent], bool]) -> None:
        self._on_event = on_event
        super().__init__()
        self.setFrameShape(QAbstractScrollArea.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.viewport().setMouseTracking(True)
        self.share = 1.0
        """Ratio of this view's scale to the transform's, for a view of another size."""
        self.frame = QRectF()
        """Rectangle of the frame, in image coordinates."""
        self.transform = QTransform()
        """From image coordinates to the viewport."""
        self._message = ""
        self._hatch: QBrush | None = None
        self._is_hatched = False
        self.has_lines = True
        """Whether lines around blocks are drawn on this picture."""
        self.striped: Mapping[str, NDArray[np.bool_]] = {}
        """What is striped over this picture -> its pixels, bool (H, W)."""
        self._drawings: list[Drawing] = []
        self.image, self.fills = PixelItem(0), PixelItem(1)
        self.points = PointsItem(3)
        self.stripes, self.lines = ScreenItem(4), ScreenItem(5)
        self.names = Names(5.5)
        self.preview = PreviewDrawing(6)
        # two, so that a moving cursor repaints two thin strips instead of the view
        self._cross = tuple(HaloPath(1, QColor(255, 255, 255, 190), 70, 7) for _ in range(2))
        self._cursor: tuple[int, int] | None = None
        below = self.image, self.fills, self.points, self.stripes, self.lines
        for drawing in (*below, self.names, self.preview, *self._cross):
            self.add(drawing)

    def add(self, drawing: Drawing) -> None:
        """Add a drawing over the picture, which is there while there is a picture."""
        drawing.repaint = lambda extent, margin: self.viewport().update(self._place_of(extent, margin))
        self._drawings.append(drawing)
        self._drawings.sort(key=lambda one: one.z)

    def _place_of(self, extent: QRectF, margin: float) -> QRect:
        """Pixels of the viewport that an extent covers, and a margin around it [screen px]."""
        reach = margin + 1  # for smooth lines
        return self.transform.mapRect(extent).adjusted(-reach, -reach, reach, reach).toAlignedRect()

    def set_frame_size(self, width: int, height: int) -> None:
        """Set the frame's size in image pixels."""
        self.frame = QRectF(0, 0, width, height)
        for item in (self.stripes, self.lines):
            item.set_extent(self.frame)

    def set_picture(self, pixels: Pixels | None, is_hatched: bool = False) -> None:
        """Show colours, uint32 (H, W), over stripes where they are transparent if `is_hatched`; None shows the
        message."""
        self._is_hatched = is_hatched
        self.image.set_pixels(pixels)
        self.viewport().update()

    def set_message(self, text: str) -> None:
        """Set the text in the middle of the view while it has no picture."""
        self._message = text
        self.viewport().update()

    def set_hatch(self, hatch: QBrush) -> None:
        """Set the stripes where a picture is transparent."""
        self._hatch = hatch
        self.viewport().update()

    def visible_box(self) -> Box:
        """Return the box (rows, columns) of the image that is visible."""
        seen = self.transform.inverted()[0].mapRect(QRectF(self.viewport().rect()))
        shown = (seen & self.frame).toAlignedRect()
        return slice(shown.top(), shown.bottom() + 1), slice(shown.left(), shown.right() + 1)

    def show_transform(self, transform: ViewTransform) -> None:
        """Apply the transform."""
        scale, size, ratio = transform.scale * self.share, self.viewport().size(), self.devicePixelRatioF()
        # whole device pixels: at 1:1 every image pixel then covers exactly one
        dx = round((size.width() / 2 - transform.x * scale) * ratio) / ratio
        dy = round((size.height() / 2 - transform.y * scale) * ratio) / ratio
        self.transform = QTransform(scale, 0, 0, scale, dx, dy)
        self.names.visible = self.share > _MIN_SHARE_FOR_NAMES
        self.show_cursor(self._cursor)
        self.viewport().update()

    @property
    def pixel_ratio(self) -> int:
        """Device pixels per screen pixel, rounded."""
        return max(round(self.devicePixelRatioF()), 1)

    def write_names(self, names: Mapping[int, str], points: Mapping[int, InnerPoint]) -> None:
        """Write names by label at inner points of their blocks."""
        self.names.set_names(names, points, self.frame)

    def to_image(self, position: QPointF) -> QPointF:
        """Image coordinates of the middle of the screen pixel at a position in the viewport.

        The middle is what painting samples: its corner may still lie in the image pixel before.
        """
        half = 0.5 / self.devicePixelRatioF()
        return self.transform.inverted()[0].map(position + QPointF(half, half))

    def show_cursor(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on the centre of a pixel (x, y); None hides it."""
        self._cursor = pixel
        paths = (QPainterPath(), QPainterPath())
        if pixel is not None:
            x, y = pixel[0] + 0.5, pixel[1] + 0.5
            scale, frame = self.transform.m11(), self.frame
            gap = max(_CROSS_GAP / scale, 0.5 + 3 / scale)
            across = QLineF(frame.left(), y, x - gap, y), QLineF(x + gap, y, frame.right(), y)
            down = QLineF(x, frame.top(), x, y - gap), QLineF(x, y + gap, x, frame.bottom())
            for path, lines in zip(paths, (across, down), strict=True):
                for line in lines:
                    if line.dx() > 0 or line.dy() > 0:
                        path.moveTo(line.p1())
                        path.lineTo(line.p2())
        for item, path in zip(self._cross, paths, strict=True):
            item.set_path(path)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint what is in the region; without a picture, the message; a frame in the accent colour with the focus."""
        painter, room, colours = QPainter(self.viewport()), self.viewport().rect(), theme.colours(self.palette())
        region, to_screen = event.region(), self.transform if self.is_of_frame else self._fitting()
        scale = to_screen.m11()
        painter.setTransform(to_screen)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale * self.devicePixelRatioF() < 1)
        if self._is_hatched and self._hatch is not None:
            hatch = QBrush(self._hatch)
            hatch.setTransform(self.transform.inverted()[0])  # in screen scale, but moving with the picture
            painter.fillRect(self.frame, hatch)
        for drawing in self._drawings if self.image.pixels is not None else ():
            extent = drawing.extent
            is_there = drawing.visible and (self.is_of_frame or drawing is self.image)
            if is_there and extent is not None and region.intersects(self._place_of(extent, drawing.margin)):
                painter.save()
                drawing.paint(painter, 1 / scale)
                painter.restore()
        painter.resetTransform()
        painter.setPen(colours.muted)
        if self.image.pixels is None:
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self._message)
        if self.hasFocus():
            painter.setPen(colours.accent)
            for inset in range(FOCUS_WIDTH):
                painter.drawRect(room.adjusted(inset, inset, -inset - 1, -inset - 1))

    def _fitting(self) -> QTransform:
        """From the pixels of a picture that is not of the frame to the viewport."""
        room, picture = QRectF(self.viewport().rect()), self.image.extent or QRectF(0, 0, 1, 1)
        scale = min(room.width() / picture.width(), room.height() / picture.height())
        corner = room.center() - picture.center() * scale
        return QTransform(scale, 0, 0, scale, corner.x(), corner.y())

    def sizeHint(self) -> QSize:
        return QSize(320, 240)

    def resizeEvent(self, event: QResizeEvent) -> None:
        self.resized.emit()

    def viewportEvent(self, event: QEvent) -> bool:
        if self.is_of_frame and event.type() in self._EVENTS and self._on_event(self, event):
            event.accept()
            return True
        return super().viewportEvent(event)

    def event(self, event: QEvent) -> bool:
        if event.type() in self._KEYS and self._on_event(self, event):
            event.accept()
            return True
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.viewport().update()
        return super().event(event)

    def keyPressEvent(self, event: QEvent) -> None:
        # leave keys to the window
        event.ignore()

    def keyReleaseEvent(self, event: QEvent) -> None:
        event.ignore()
