"""Pictures whose pixels are changed in place: a change in a small box only costs that box."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPen, QPolygonF

from ilf.data.label_map import Box
from ilf.segmentation.editing.patches import bounds

from .drawings import Drawing

# Arrays to Qt images.


def rgb_image(rgb: NDArray[np.uint8]) -> QImage:
    """QImage that owns its pixels, from uint8 (H, W, 3), red first."""
    pixels = np.ascontiguousarray(rgb)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()


def image_over(pixels: NDArray[np.uint32], form: QImage.Format) -> QImage:
    """QImage that shares the memory of an array (H, W), which must outlive it; 4 bytes per pixel."""
    height, width = pixels.shape
    return QImage(pixels.data, width, height, 4 * width, form) if pixels.size else QImage()


_FORMAT = QImage.Format.Format_RGBA8888_Premultiplied
"""Qt scales this format exactly; its faster code for other formats is off by one pixel in places."""
Pixels = NDArray[np.uint32]
"""Premultiplied colours, each at most as large as alpha."""


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
        self.repaint(_rectangle(box), 0)

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


def _rectangle(box: Box) -> QRectF:
    rows, columns = box
    return QRectF(columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start)


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


def boundary_path(mask: NDArray[np.bool_], x: int = 0, y: int = 0) -> QPainterPath:
    """Outline of a mask, bool (h, w), with its corner at (x, y); empty if no pixel is marked.

    The path follows pixel edges, not centres, so it never covers half a pixel of a neighbouring block.
    """
    box = bounds(mask)
    if box is None:
        return QPainterPath()
    x, y, padded = x + box[1].start, y + box[0].start, np.pad(mask[box], 1)
    rows, left, right = _runs(padded[1:, 1:-1] != padded[:-1, 1:-1])
    columns, top, bottom = _runs((padded[1:-1, 1:] != padded[1:-1, :-1]).T)
    ends_x = np.concatenate((np.column_stack((left, right)).ravel(), np.repeat(columns, 2)))
    ends_y = np.concatenate((np.repeat(rows, 2), np.column_stack((top, bottom)).ravel()))
    return pg.arrayToQPath(
        (ends_x + x).astype(np.float64), (ends_y + y).astype(np.float64), connect="pairs", finiteCheck=False
    )


def filled_path(mask: NDArray[np.bool_]) -> QPainterPath:
    """The pixels of a mask, bool (H, W), as an area to fill."""
    path = QPainterPath()
    for row, left, right in zip(*_runs(mask), strict=True):
        path.addRect(int(left), int(row), int(right - left), 1)
    return path


def _runs(edges: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Row, start and stop of every run of True along the rows."""
    padded = np.pad(edges, ((0, 0), (1, 1)))
    # in a row, starts and stops alternate
    rows, columns = np.divmod(np.flatnonzero(padded[:, 1:] != padded[:, :-1]), edges.shape[1] + 1)
    return rows[::2], columns[::2], columns[1::2]


# Boxes of changed pixels, so that only those are redrawn.


def changed_box(before: NDArray[Any], after: NDArray[Any]) -> Box | None:
    """Smallest box (rows, columns) that contains all differences of two arrays (H, W); None if equal (NaN == NaN).

    Both have the same shape and type: float32, or one without NaN.
    """
    plain = np.int32 if before.dtype == np.float32 else before.dtype
    return bounds(before.view(plain) != after.view(plain))
