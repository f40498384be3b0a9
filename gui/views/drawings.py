"""What a view draws over its picture, in image coordinates, with line widths in screen pixels at every zoom."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from statistics import median

import cv2
import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QFontMetricsF,
    QImage,
    QPainter,
    QPainterPath,
    QPen,
    QPixmap,
    QPolygonF,
)

from ilf.data.blocks import Box
from ilf.drawing.blocks import InnerPoint

from ..base.theme import Colours, blend
from .interaction import Preview

_TILE = 8


class Drawing:
    """Something that a view draws, in an extent in image coordinates and a margin around it in screen pixels.

    Parameters
    ----------
    z : float
        Stacking order.

    Attributes
    ----------
    extent : QRectF or None
        The rectangle drawn in, without the margin; None for nothing.
    margin : float
    visible : bool
    repaint : callable
        Paints an extent and a margin around it anew; set by the view.
    """

    def __init__(self, z: float) -> None:
        self.z = z
        self.extent: QRectF | None = None
        self.margin = 0.0
        self.visible = True
        self.repaint: Callable[[QRectF, float], None] = lambda extent, margin: None

    def set_extent(self, extent: QRectF | None, margin: float = 0.0) -> None:
        """Set the rectangle drawn in, plus `margin` screen pixels around it; None for nothing."""
        self._repaint_all()
        self.extent, self.margin = extent, margin
        self._repaint_all()

    def set_visible(self, on: bool) -> None:
        """Show or hide it."""
        if on != self.visible:
            self.visible = on
            self._repaint_all()

    def paint(self, painter: QPainter, pixel: float) -> None:
        """Paint it, in image coordinates; a screen pixel is `pixel` image pixels. The view restores the painter."""
        raise NotImplementedError

    def _repaint_all(self) -> None:
        if self.extent is not None:
            self.repaint(self.extent, self.margin)


def rgb_image(rgb: NDArray[np.uint8]) -> QImage:
    """QImage that owns its pixels, from uint8 (H, W, 3), red first."""
    pixels = np.ascontiguousarray(rgb)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()


class HaloPath(Drawing):
    """Path in image coordinates: a bright line on a wider dark one, visible on any picture."""

    def __init__(self, width: float, colour: QColor, halo_alpha: int, z: float) -> None:
        super().__init__(z)
        self.path = QPainterPath()
        self._colour = colour
        self._width = width
        self._halo = QColor(0, 0, 0, halo_alpha)

    def set_path(self, path: QPainterPath | None) -> None:
        """Draw another path, None for nothing."""
        self.path = QPainterPath() if path is None else path
        self.set_extent(None if self.path.isEmpty() else self.path.controlPointRect(), self._width + 3)

    def paint(self, painter: QPainter, pixel: float) -> None:
        for colour, width in ((self._halo, self._width + 2), (self._colour, self._width)):
            pen = QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.SquareCap, Qt.PenJoinStyle.MiterJoin)
            pen.setCosmetic(True)
            painter.setPen(pen)
            painter.drawPath(self.path)


def missing_brush(colours: Colours) -> QBrush:
    """Seamless diagonal stripes that are visible where depth is missing."""
    tile = QPixmap(_TILE, _TILE)
    tile.fill(blend(colours.background, colours.text, 0.12))
    painter = QPainter(tile)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(QPen(blend(colours.background, colours.text, 0.3), 1.6))
    for offset in (-_TILE, 0, _TILE):
        painter.drawLine(offset, _TILE, offset + _TILE, 0)
    painter.end()
    return QBrush(tile)


# Pictures whose pixels are changed in place: a change in a small box only costs that box.


def image_over(pixels: NDArray[np.uint32], form: QImage.Format) -> QImage:
    """QImage that shares the memory of an array (H, W), which must outlive it; 4 bytes per pixel."""
    height, width = pixels.shape
    return QImage(pixels.data, width, height, 4 * width, form) if pixels.size else QImage()


_FORMAT = QImage.Format.Format_RGBA8888_Premultiplied
"""Qt scales this format exactly; its faster code for other formats is off by one pixel in places."""
Pixels = NDArray[np.uint32]
"""Premultiplied colours, each at most as large as alpha."""


def rgb_pixels(rgb: NDArray[np.uint8]) -> Pixels:
    """Pack colour, uint8 (H, W, 3), red first."""
    pixels: Pixels = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2RGBA).view(np.uint32)[..., 0]
    return pixels


def packed(table: NDArray[np.uint8]) -> Pixels:
    """Pack colours, uint8 (N, 4) RGBA, into N numbers as in `PixelItem.pixels`: premultiplied, red lowest."""
    colours = table.astype(np.uint32)
    alpha = colours[:, 3]
    red, green, blue = ((colours[:, channel] * alpha + 127) // 255 for channel in range(3))
    return ((alpha << 24) | (blue << 16) | (green << 8) | red).astype(np.uint32)


def greyed(colours: Pixels) -> Pixels:
    """Desaturate opaque or transparent colours, slightly towards mid-grey."""
    red, green, blue = (colours & 255, (colours >> 8) & 255, (colours >> 16) & 255)
    grey = (red * 2 + green * 5 + blue) // 8
    faded = [(channel + 4 * grey + 2 * 128) // 7 for channel in (red, green, blue)]
    mixed = (colours & 0xFF000000) | (faded[2] << 16) | (faded[1] << 8) | faded[0]
    return np.where(colours >> 24 > 0, mixed, 0).astype(np.uint32)


class PixelItem(Drawing):
    """Picture in image coordinates, one unit per pixel.

    Attributes
    ----------
    pixels : ndarray of uint32, shape (H, W), or None
        Colours as `packed`, which whoever has set them may change in place; None for no picture.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.pixels: Pixels | None = None
        self._drawn = QImage()

    def set_pixels(self, pixels: Pixels | None) -> None:
        """Show an array; None shows nothing."""
        self.pixels = None if pixels is None else np.ascontiguousarray(pixels)
        self._drawn = QImage() if self.pixels is None else image_over(self.pixels, _FORMAT)
        self.set_extent(None if pixels is None else QRectF(0, 0, self._drawn.width(), self._drawn.height()))

    def notify_change(self, box: Box) -> None:
        """Repaint after the pixels changed inside a box (rows, columns)."""
        rows, columns = box
        self.repaint(QRectF(columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start), 0)

    def paint(self, painter: QPainter, pixel: float) -> None:
        # draw the whole image: Qt clips it, and a part of it would be rounded to other screen positions
        painter.drawImage(QRectF(self._drawn.rect()), self._drawn)


Argb = NDArray[np.uint32]
"""Device pixels as Qt's premultiplied ARGB: 0xAARRGGBB, each colour at most as large as alpha."""


class ScreenItem(Drawing):
    """Device pixels over the visible part of the frame.

    Attributes
    ----------
    find : callable
        Finds the pixels, as they are to be painted; None for none.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.find: Callable[[], Argb | None] = lambda: None

    def paint(self, painter: QPainter, pixel: float) -> None:
        pixels, corner = self.find(), painter.worldTransform()
        if pixels is not None:
            drawn = image_over(pixels, QImage.Format.Format_ARGB32_Premultiplied)
            drawn.setDevicePixelRatio(painter.device().devicePixelRatioF())
            painter.resetTransform()
            painter.drawImage(QPointF(max(corner.dx(), 0.0), max(corner.dy(), 0.0)), drawn)


_BRIGHT_RIM, _DARK_RIM = QColor(255, 255, 255, 150), QColor(0, 0, 0, 160)


class PointsItem(Drawing):
    """Dots over the single pixels of a sparse picture, which would vanish in a view that is smaller than it."""

    SIZE = 4
    """Side of a dot in screen pixels; larger pixels need none."""
    RIM = 1
    """Width of its rim, which is bright around dark dots and dark around bright ones: on any ground it can be seen."""

    SPARSE, MOST = 0.05, 50_000
    """Largest share of the pixels, and largest number, that are drawn as dots."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.dots: list[tuple[QColor, QPolygonF]] = []
        """Colours, and the middles of the pixels that have them."""

    def set_indices(self, indices: NDArray[np.uint8], table: NDArray[np.uint8]) -> None:
        """Draw a dot for every index but 0, uint8 (H, W), through a table of RGBA, uint8 (256, 4); none if there are
        too many."""
        drawn = indices != 0
        if np.count_nonzero(drawn) > min(self.SPARSE * indices.size, self.MOST):
            drawn[:] = False
        places = np.flatnonzero(drawn)
        rows, columns = np.divmod(places, indices.shape[1])
        colours = indices.ravel()[places]
        self.dots = [
            (
                QColor(*map(int, table[k])),
                pg.functions.arrayToQPolygonF(columns[colours == k] + 0.5, rows[colours == k] + 0.5),
            )
            for k in np.unique(colours)
        ]
        extent = QRectF(0, 0, indices.shape[1], indices.shape[0])
        self.set_extent(extent if self.dots else None, self.SIZE / 2 + self.RIM)

    def paint(self, painter: QPainter, pixel: float) -> None:
        if pixel * self.SIZE <= 1:
            return
        rims = [(_BRIGHT_RIM if colour.lightness() < 128 else _DARK_RIM, middles) for colour, middles in self.dots]
        for dots, size in ((rims, self.SIZE + 2 * self.RIM), (self.dots, self.SIZE)):
            for colour, middles in dots:
                pen = QPen(colour, size)
                pen.setCosmetic(True)
                painter.setPen(pen)
                painter.drawPoints(middles)


# The preview of a tool.

_LINE, _HALO, _SHADE = QColor(255, 221, 51), QColor(0, 0, 0, 200), QColor(0, 0, 0, 110)
_WIDTH = 2.0
_HANDLE = 2.0, 4.0
"""Half the side of a handle [screen px], minimum and maximum."""


class PreviewDrawing(Drawing):
    """Draws the preview of a tool, or lines of another colour in the same way."""

    def __init__(self, z: float, colour: QColor = _LINE) -> None:
        super().__init__(z)
        self._colour = colour
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

    def paint(self, painter: QPainter, pixel: float) -> None:
        preview = self.preview
        if preview is None:
            return
        if preview.area is not None:
            painter.fillPath(preview.area, _SHADE)
            painter.fillPath(preview.area, QBrush(self._colour, Qt.BrushStyle.BDiagPattern))
        # straight lines along the pixels' edges are clearer without; others are not
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if preview.line_preview is not None:
            _draw(painter, preview.line_preview, self._colour, dashed=True)
        _draw(painter, preview.line, self._colour, preview.dashed)
        half = pixel * _half_handle(preview.corners, pixel)
        painter.setPen(pg.mkPen(_HALO, width=1.5))
        painter.setBrush(self._colour)
        for x, y in preview.corners:
            painter.drawRect(QRectF(QPointF(x - half, y - half), QPointF(x + half, y + half)))


def _half_handle(corners: Sequence[tuple[float, float]], pixel: float) -> float:
    """Half the side of a handle [screen px]: smaller where most corners are close together, as in a small view."""
    least, most = _HANDLE
    if len(corners) < 2:
        return most
    apart = median(math.dist(one, other) for one, other in pairwise(corners)) / pixel
    return min(max(apart / 5, least), most)


def _draw(painter: QPainter, path: QPainterPath, bright: QColor, dashed: bool) -> None:
    for colour, width in ((_HALO, _WIDTH + 2), (bright, _WIDTH)):
        pen = pg.mkPen(colour, width=width, dash=[4, 3] if dashed and colour is bright else None)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.drawPath(path)


# Names of blocks, each at a point well inside its block.

_MIN_NAME_RADIUS = 5.0
"""Minimum radius of the inscribed circle on the screen [px] for a block to show its name."""
_PAD = 3.0


class Names(Drawing):
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

    def paint(self, painter: QPainter, pixel: float) -> None:
        to_screen, metrics = painter.worldTransform(), QFontMetricsF(self._font)
        painter.resetTransform()
        painter.setFont(self._font)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for text, (x, y, radius) in self._texts:
            if radius >= _MIN_NAME_RADIUS * pixel:
                write_on_plate(painter, to_screen.map(QPointF(x, y)), text, metrics)


def write_on_plate(painter: QPainter, middle: QPointF, text: str, metrics: QFontMetricsF) -> None:
    """Write a text on a dark plate around a point of the screen."""
    plate = QRectF(0, 0, metrics.horizontalAdvance(text) + 2 * _PAD, metrics.height())
    plate.moveCenter(middle)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(0, 0, 0, 150))
    painter.drawRoundedRect(plate, 3, 3)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QColor("white"))
    painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)
