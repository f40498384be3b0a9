"""View of one picture in image coordinates, with overlays; no application logic."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QLineF, QPointF, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QResizeEvent, QTransform
from PySide6.QtWidgets import QGraphicsItem, QGraphicsRectItem, QStyleOptionGraphicsItem, QWidget

from ilf.data.label_map import Box
from ilf.drawing.blocks import InnerPoint

from ..base import theme
from .interaction import PreviewItem
from .pixel_items import PixelItem, Pixels, PointsItem
from .scene_items import HaloPath, Hatch, ViewItem
from .screen_items import Sampling, ScreenItem

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


# Names of blocks, each at a point well inside its block.

_MIN_NAME_RADIUS = 5.0
"""Minimum radius of the inscribed circle on the screen [px] for a block to show its name."""
_PAD = 3.0


class NamesItem(ViewItem):
    """Block names in a fixed size on the screen, on dark plates so that they are readable on any picture."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self._texts: list[tuple[str, InnerPoint]] = []
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)

    @property
    def texts(self) -> list[str]:
        """All names, including those without room."""
        return [text for text, _ in self._texts]

    def set_names(self, names: Mapping[int, str], points: Mapping[int, InnerPoint], frame: QRectF) -> None:
        """Write names by label at the inner points of their blocks, within the frame."""
        self._texts = [(names[label], point) for label, point in points.items() if label in names]
        metrics = QFontMetricsF(self._font)
        widest = max((metrics.horizontalAdvance(text) for text in self.texts), default=0.0)
        self.set_extent(frame if self._texts else None, widest / 2 + _PAD + metrics.height())

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        transform = painter.worldTransform()
        scale, metrics = transform.m11(), QFontMetricsF(self._font)
        painter.save()
        painter.resetTransform()
        painter.setFont(self._font)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for text, (x, y, radius) in self._texts:
            if radius * scale < _MIN_NAME_RADIUS:
                continue
            plate = QRectF(0, 0, metrics.horizontalAdvance(text) + 2 * _PAD, metrics.height())
            plate.moveCenter(transform.map(QPointF(x, y)))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(0, 0, 0, 150))
            painter.drawRoundedRect(plate, 3, 3)
            painter.setPen(QColor("white"))
            painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()


FOCUS_WIDTH = 2
_CROSS_GAP = 9
_MIN_SHARE_FOR_NAMES = 0.5


class ImageView(pg.GraphicsView):
    """Scene with one image, its layers, lines and stripes over them, a tool's preview and the crosshair.

    Parameters
    ----------
    on_event : callable
        Receives (view, event) for every mouse, wheel, key and leave event; True if it handled the event.
    """

    resized = Signal()

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
        super().__init__(useOpenGL=False)
        self.setCentralItem(None)
        self.viewport().setMouseTracking(True)
        self.share = 1.0
        """Ratio of this view's scale to the transform's, for a view of another size."""
        self._frame = QRectF()
        self._message = ""
        self._pixel_size = 1.0
        self.image = self.add_picture(PixelItem(0))
        self.hatch = Hatch(-1)
        self.addItem(self.hatch)
        self.points = PointsItem(3)
        self.stripes = ScreenItem(4)
        self.lines = ScreenItem(5)
        self.names = NamesItem(5.5)
        self.has_lines = True
        """Whether lines around blocks are drawn on this picture."""
        self.striped: Mapping[str, NDArray[np.bool_]] = {}
        """What is striped over this picture -> its pixels, bool (H, W)."""
        self.sampling: Sampling | None = None
        """Mapping of the frame to device pixels; None until known."""
        self.preview = PreviewItem(6)
        # two items, so that a moving cursor repaints two thin strips instead of the view
        self._cross = tuple(HaloPath(1, QColor(255, 255, 255, 190), 70, 7) for _ in range(2))
        self._cursor: tuple[int, int] | None = None
        self._overlays: list[ViewItem] = []
        self._overlay_parent = QGraphicsRectItem()
        self._overlay_parent.setFlag(QGraphicsItem.GraphicsItemFlag.ItemHasNoContents)
        self._overlay_parent.setZValue(4)
        self.addItem(self._overlay_parent)
        for item in (self.points, self.stripes, self.lines, self.names, self.preview, *self._cross):
            self.add_overlay(item)

    def add_picture(self, item: PixelItem) -> PixelItem:
        """Add a picture: the view's own is at height 0, overlays are at 4 and above."""
        self.addItem(item)
        return item

    def add_overlay(self, item: ViewItem) -> None:
        """Add an item over the picture, visible while there is a picture."""
        item.set_pixel_size(self._pixel_size)
        item.setParentItem(self._overlay_parent)
        self._overlays.append(item)

    def set_frame_size(self, width: int, height: int) -> None:
        """Set the frame's size in image pixels."""
        self._frame = QRectF(0, 0, width, height)
        self.hatch.set_extent(self._frame)

    def set_picture(self, pixels: Pixels | None, is_hatched: bool = False) -> None:
        """Show colours, uint32 (H, W), over stripes where they are transparent if `is_hatched`; None shows the
        message."""
        self.hatch.setVisible(is_hatched)
        self.image.set_pixels(pixels)
        self._show_layers()
        self.viewport().update()

    def _show_layers(self) -> None:
        """Show overlays only with a picture, and names only in large views."""
        self._overlay_parent.setVisible(self.image.pixels is not None)
        self.names.setVisible(self.share > _MIN_SHARE_FOR_NAMES)

    def set_message(self, text: str) -> None:
        """Set the text in the middle of the view while it has no picture."""
        self._message = text
        self.viewport().update()

    def set_colours(self, colours: theme.Colours, hatch: QBrush) -> None:
        """Apply the theme's colours."""
        self.setBackground(colours.background)
        self.hatch.set_brush(hatch)
        self.viewport().update()

    def visible_box(self) -> Box:
        """Return the box (rows, columns) of the image that is visible."""
        seen = self.viewportTransform().inverted()[0].mapRect(QRectF(self.viewport().rect()))
        shown = (seen & QRectF(0, 0, self._frame.width(), self._frame.height())).toAlignedRect()
        return slice(shown.top(), shown.bottom() + 1), slice(shown.left(), shown.right() + 1)

    def show_transform(self, transform: ViewTransform) -> None:
        """Apply the transform."""
        scale, size, ratio = transform.scale * self.share, self.viewport().size(), self.devicePixelRatioF()
        width, height = round(self._frame.width()), round(self._frame.height())
        # whole device pixels: at 1:1 every image pixel then covers exactly one
        dx = round((size.width() / 2 - transform.x * scale) * ratio) / ratio
        dy = round((size.height() / 2 - transform.y * scale) * ratio) / ratio
        drawn = QTransform(scale, 0, 0, scale, dx, dy)
        self.sampling = Sampling(
            scale * ratio,
            round(dx * ratio),
            round(dy * ratio),
            (round(size.width() * ratio), round(size.height() * ratio)),
            (width, height),
        )
        self.setTransform(drawn)
        self._show_layers()
        # the visible part as scene rectangle leaves nothing to scroll
        self.setSceneRect(drawn.inverted()[0].mapRect(QRectF(QRect(0, 0, size.width(), size.height()))))
        self.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale * ratio < 1)
        self._pixel_size = 1 / scale
        for item in self._overlays:
            item.set_pixel_size(self._pixel_size)
        self.show_cursor(self._cursor)

    @property
    def pixel_ratio(self) -> int:
        """Device pixels per screen pixel, rounded."""
        return max(round(self.devicePixelRatioF()), 1)

    def write_names(self, names: Mapping[int, str], points: Mapping[int, InnerPoint]) -> None:
        """Write names by label at inner points of their blocks."""
        self.names.set_names(names, points, self._frame)

    def to_image(self, position: QPointF) -> QPointF:
        """Image coordinates of the middle of the screen pixel at a position in the viewport.

        The middle is what painting samples: its corner may still lie in the image pixel before.
        """
        half = 0.5 / self.devicePixelRatioF()
        return self.viewportTransform().inverted()[0].map(position + QPointF(half, half))

    def show_cursor(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on the centre of a pixel (x, y); None hides it."""
        self._cursor = pixel
        paths = (QPainterPath(), QPainterPath())
        if pixel is not None:
            x, y = pixel[0] + 0.5, pixel[1] + 0.5
            scale, frame = self.transform().m11(), self._frame
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

    def drawForeground(self, painter: QPainter, rect: QRectF) -> None:
        """Draw the message, and a frame in the accent colour while the view has the keyboard focus."""
        room, colours = self.viewport().rect(), theme.colours(self.palette())
        painter.save()
        painter.resetTransform()
        painter.setPen(colours.muted)
        if self.image.pixels is None:
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self._message)
        if self.hasFocus():
            painter.setPen(colours.accent)
            painter.setBrush(Qt.BrushStyle.NoBrush)
            for inset in range(FOCUS_WIDTH):
                painter.drawRect(room.adjusted(inset, inset, -inset - 1, -inset - 1))
        painter.restore()

    def sizeHint(self) -> QSize:
        return QSize(320, 240)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        self.resized.emit()

    def viewportEvent(self, event: QEvent) -> bool:
        if event.type() in self._EVENTS and self._on_event(self, event):
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
        # no item in the scene uses keys: leave them to the window
        event.ignore()

    def keyReleaseEvent(self, event: QEvent) -> None:
        event.ignore()
