"""View of one layer in image coordinates, with overlays: of a layer, only what has changed is drawn again."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QLineF, QPointF, QRect, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QResizeEvent, QTransform
from PySide6.QtWidgets import QAbstractScrollArea

from ilf.data.blocks import Box, bounds, union, whole
from ilf.drawing.colours import sample

from ..base import theme
from .drawings import (
    Argb,
    Drawing,
    HaloPath,
    Names,
    PixelItem,
    Pixels,
    PointsItem,
    PreviewDrawing,
    ScreenItem,
    greyed,
    missing_brush,
    packed,
    rgb_pixels,
)
from .layers import Layer

EVERYWHERE: Box = slice(None), slice(None)
FOCUS_WIDTH = 2
_CROSS_GAP = 9
_MIN_SHARE_FOR_NAMES = 0.5

Rims = tuple[tuple[bool, bool], ...]


@dataclass(frozen=True)
class Sampling:
    """Mapping of a frame to the device pixels of a view.

    Parameters
    ----------
    scale : float
        Device pixels per image pixel.
    x, y : int
        Device pixel of the frame's corner; may lie outside the view.
    size : (int, int)
        Width and height of the view in device pixels.
    frame : (int, int)
        Width and height of the frame.
    ratio : float
        Device pixels per screen pixel.
    """

    scale: float
    x: int
    y: int
    size: tuple[int, int]
    frame: tuple[int, int]
    ratio: float = 1.0

    @property
    def line_width(self) -> int:
        """Width [device px] of a line of one screen pixel."""
        return max(round(self.ratio), 1)

    @property
    def left(self) -> int:
        """First device pixel, from the left, that shows the frame."""
        return max(self.x, 0)

    @property
    def top(self) -> int:
        """First device pixel, from the top, that shows the frame."""
        return max(self.y, 0)

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """Image column of each device column that shows the frame."""
        return self._pixels(self.x, self.size[0], self.frame[0])

    @cached_property
    def rows(self) -> NDArray[np.intp]:
        """Image row of each device row that shows the frame."""
        return self._pixels(self.y, self.size[1], self.frame[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of device pixels that show the frame."""
        return len(self.rows), len(self.columns)

    @property
    def rims(self) -> Rims:
        """Whether the frame's rim is visible: above and below, at the left and right."""
        width, height = self.frame
        if 0 in self.shape:
            return (False, False), (False, False)
        above, below = int(self.rows[0]) == 0, int(self.rows[-1]) == height - 1
        return (above, below), (int(self.columns[0]) == 0, int(self.columns[-1]) == width - 1)

    def sample(self, values: NDArray[Any], box: Box) -> NDArray[Any]:
        """Values (H, W) of the image on a box of the device pixels that show the frame."""
        rows, columns = self.rows[box[0]], self.columns[box[1]]
        return np.take(np.take(values, rows, axis=0), columns, axis=1)

    def box_of(self, box: Box) -> Box:
        """Device pixels that show a box of the image; empty if it is not visible."""
        rows, columns = (
            slice(int(np.searchsorted(shown, span.start)), int(np.searchsorted(shown, span.stop)))
            for shown, span in zip((self.rows, self.columns), box, strict=True)
        )
        return rows, columns

    def on_screen(self, box: Box) -> QRect:
        """Screen pixels of a box of the device pixels that show the frame."""
        rows, columns = box
        corner = QPointF(columns.start + self.left, rows.start + self.top) / self.ratio
        size = QSizeF(columns.stop - columns.start, rows.stop - rows.start) / self.ratio
        return QRectF(corner, size).toAlignedRect()

    def _pixels(self, start: int, view: int, frame: int) -> NDArray[np.intp]:
        first, last = max(start, 0), min(start + math.ceil(frame * self.scale), view)
        pixels = np.floor((np.arange(first, max(last, first)) + 0.5 - start) / self.scale).astype(np.intp)
        return pixels[pixels < frame]


# Stripes over part of a picture, in screen pixels, moving with the picture. No Qt.

_PERIOD = 8
_WIDTH = 2


class Style(NamedTuple):
    """Colours of a stripe and of the dark one beside it, the direction of their slope, and the colour in legends."""

    stripe: int
    shade: int
    lean: int
    legend: str


STYLES = {
    "extrapolated": Style(0xBEBEBEBE, 0x60000000, 1, "#bebebe"),
    "missing": Style(0xE6E6E6E6, 0x96000000, 1, "#e6e6e6"),
    "outside view": Style(0xFF3C8CDC, 0x961E4678, -1, "#3c8cdc"),
    "unsupported": Style(0xFFFFFFFF, 0xDC000000, -1, "#808080"),
    "suspect": Style(0xFFFFE040, 0xDC000000, 1, "#e6be00"),
    "invalid": Style(0xFFFF9020, 0xB4000000, -1, "#ff9020"),
    "by hand": Style(0xFF9E6ECE, 0xA0FFFFFF, 1, "#9e6ece"),
}
"""What is striped -> how; later ones lie over earlier ones."""


def stripes(masks: Mapping[str, NDArray[np.bool_]], sampling: Sampling) -> Argb | None:
    """Stripes in masks, bool (H, W), by their names in `STYLES`, at the device pixels that show the frame; transparent
    elsewhere. None if there are no masks."""
    drawn, everywhere = None, whole(sampling.shape)
    period, width = _PERIOD * sampling.line_width, _WIDTH * sampling.line_width
    down = np.arange(len(sampling.rows))[:, None] + sampling.top - sampling.y
    along = np.arange(len(sampling.columns)) + sampling.left - sampling.x
    for name, mask in masks.items():
        if mask.shape == sampling.frame[::-1]:
            style = STYLES[name]
            phase = (down + style.lean * along) % period
            shade = np.where(phase < 2 * width, np.uint32(style.shade), np.uint32(0))
            pattern = np.where(phase < width, np.uint32(style.stripe), shade)
            below = np.zeros(sampling.shape, np.uint32) if drawn is None else drawn
            drawn = np.where(sampling.sample(mask, everywhere), pattern, below)
    return drawn


class ImageView(QAbstractScrollArea):
    """A layer in image coordinates, lines and stripes over it, a tool's preview and the crosshair.

    Parameters
    ----------
    on_event : callable
        Receives (view, event) for every mouse, wheel, key and leave event; True if it handled the event.

    Attributes
    ----------
    layer : Layer
        What is shown.
    drawn : list of ndarray
        Copies of the drawn arrays, those of the layer first, since the originals may be changed in place.
    shown : ndarray of uint8, or None
        Colour (H, W, 3), or indices into the layer's table (H, W); None for no picture.
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
        self.layer = Layer()
        self.drawn: list[NDArray[Any]] = []
        self.shown: NDArray[np.uint8] | None = None
        self.has_lines = True
        """Whether lines around blocks are drawn on this picture."""
        self.striped: Mapping[str, NDArray[np.bool_]] = {}
        """What is striped over this picture -> its pixels, bool (H, W)."""
        self._stripes: tuple[Sampling, Argb | None] | None = None
        self._drawings: list[Drawing] = []
        self.image, self.fills = PixelItem(0), PixelItem(1)
        self.points = PointsItem(3)
        self.stripes, self.lines = ScreenItem(4), ScreenItem(5)
        self.stripes.find = self._find_stripes
        self.names = Names(5.5)
        self.preview = PreviewDrawing(6)
        # two, so that a moving cursor repaints two thin strips instead of the view
        self._cross = tuple(HaloPath(1, QColor(255, 255, 255, 190), 70, 7) for _ in range(2))
        self.pointed: tuple[int, int] | None = None
        """The pixel (x, y) of the crosshair; None if it is hidden."""
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

    def draw(self, layer: Layer) -> None:
        """Draw a layer, as far as it is not drawn already; its message if there is no picture."""
        former, self.layer = self.layer, layer
        if layer.message or not layer.arrays:
            self._set_colour(None)
        elif layer.picture is not None:
            if former.picture is None or [*map(id, former.arrays)] != [*map(id, layer.arrays)]:
                self._set_colour(layer.picture())
        elif self.drawn and _look(former) == _look(layer):
            self._draw_changes(layer)
        else:
            self.drawn = [array.copy() for array in _arrays(layer)]
            self.shown, pixels = _coloured(layer, whole(layer.arrays[0].shape))
            self._set_pixels(pixels)

    def _set_colour(self, rgb: NDArray[np.uint8] | None) -> None:
        self.drawn, self.shown = [], rgb
        self._set_pixels(None if rgb is None else rgb_pixels(rgb))

    def _set_pixels(self, pixels: Pixels | None) -> None:
        self.image.set_pixels(pixels)
        self._set_dots()
        self.viewport().update()

    def _set_dots(self) -> None:
        if self.layer.has_dots and self.drawn and self.shown is not None:
            self.points.set_indices(self.shown, self.layer.table)
        else:
            self.points.set_extent(None)

    def _draw_changes(self, layer: Layer) -> None:
        arrays, shown, pixels = _arrays(layer), self.shown, self.image.pixels
        changed = [changed_box(drawn, now) for drawn, now in zip(self.drawn, arrays, strict=True)]
        boxes = [box for box in changed if box is not None]
        if not boxes or shown is None or pixels is None:
            return
        box = reduce(union, boxes)
        for drawn, now in zip(self.drawn, arrays, strict=True):
            drawn[box] = now[box]
        shown[box], pixels[box] = _coloured(layer, box)
        self.image.notify_change(box)
        self._set_dots()

    @property
    def _arrays(self) -> list[NDArray[Any]]:
        return self.drawn[: len(self.layer.arrays)]

    def value_at(self, x: int, y: int) -> float | None:
        """Value at a pixel, in the unit of the colour bar; None if there is none."""
        return self.layer.value_at(x, y, self._arrays)

    def values(self, where: Box | NDArray[np.bool_] = EVERYWHERE) -> NDArray[np.floating] | None:
        """Values shown in a box or a mask (H, W), or a sample of them, in the unit of the colour bar, NaN = missing.

        None if there are none.
        """
        return self.layer.measure(*(sample(array[where]) for array in self._arrays)) if self.drawn else None

    def visible_box(self) -> Box:
        """Return the box (rows, columns) of the image that is visible."""
        seen = self.transform.inverted()[0].mapRect(QRectF(self.viewport().rect()))
        shown = (seen & self.frame).toAlignedRect()
        return slice(shown.top(), shown.bottom() + 1), slice(shown.left(), shown.right() + 1)

    def show_place(self, x: float, y: float, scale: float) -> None:
        """Show an image point in the middle, at a scale of which this view has its share."""
        scale, size, ratio = scale * self.share, self.viewport().size(), self.devicePixelRatioF()
        # whole device pixels: at 1:1 every image pixel then covers exactly one
        dx = round((size.width() / 2 - x * scale) * ratio) / ratio
        dy = round((size.height() / 2 - y * scale) * ratio) / ratio
        self.transform = QTransform(scale, 0, 0, scale, dx, dy)
        self.names.visible = self.share > _MIN_SHARE_FOR_NAMES
        self.show_cursor(self.pointed)
        self.viewport().update()

    @property
    def sampling(self) -> Sampling:
        """The mapping of the frame to device pixels as it is now."""
        transform, size, frame, ratio = self.transform, self.viewport().size(), self.frame, self.devicePixelRatioF()
        corner = round(transform.dx() * ratio), round(transform.dy() * ratio)
        room = round(size.width() * ratio), round(size.height() * ratio)
        return Sampling(transform.m11() * ratio, *corner, room, (round(frame.width()), round(frame.height())), ratio)

    def stripe(self, masks: Mapping[str, NDArray[np.bool_]]) -> None:
        """Stripe the pixels of these masks, bool (H, W), by their names in `STYLES`, from below."""
        if [*masks] != [*self.striped] or any(mask is not self.striped[name] for name, mask in masks.items()):
            self.striped, self._stripes = masks, None
            self.viewport().update()

    def _find_stripes(self) -> Argb | None:
        sampling = self.sampling
        if self._stripes is None or self._stripes[0] != sampling:
            self._stripes = sampling, stripes(self.striped, sampling)
        return self._stripes[1]

    def to_image(self, position: QPointF) -> QPointF:
        """Image coordinates of the middle of the screen pixel at a position in the viewport.

        The middle is what painting samples: its corner may still lie in the image pixel before.
        """
        half = 0.5 / self.devicePixelRatioF()
        return self.transform.inverted()[0].map(position + QPointF(half, half))

    def show_cursor(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on the centre of a pixel (x, y); None hides it."""
        self.pointed = pixel
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
        if self.drawn:  # values, transparent where they are missing
            hatch = missing_brush(colours)
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
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self.layer.message)
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


def _coloured(layer: Layer, box: Box) -> tuple[NDArray[np.uint8], Pixels]:
    """Indices and colours of a layer in a box: stale values in grey, and marks where there are none."""
    arrays = [array[box] for array in layer.arrays]
    indices, table = layer.indices(*arrays), packed(layer.table)
    colours = table[indices]
    stale = None if layer.stale is None else layer.stale[box]
    if stale is not None and stale.any():
        colours[stale] = greyed(table)[indices[stale]]
    if layer.marks is not None and layer.mark_table is not None:
        missing = indices == 0
        colours[missing] = packed(layer.mark_table)[layer.marks(*arrays)[missing]]
    return indices, colours


def _arrays(layer: Layer) -> list[NDArray[Any]]:
    return [*layer.arrays, *([] if layer.stale is None else [layer.stale])]


def _look(layer: Layer) -> list[Any]:
    """All but the pixels: which arrays are there, their size, and their colours."""
    return [*layer.look, layer.stale is None, [array.shape for array in layer.arrays]]


def changed_box(before: NDArray[Any], after: NDArray[Any]) -> Box | None:
    """Smallest box (rows, columns) that contains all differences of two arrays (H, W); None if equal (NaN == NaN).

    Both have the same shape and type: float32, or one without NaN.
    """
    plain = np.int32 if before.dtype == np.float32 else before.dtype
    return bounds(before.view(plain) != after.view(plain))
