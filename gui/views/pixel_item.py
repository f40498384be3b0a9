"""A picture in the scene whose pixels are changed in place: what changes in a small box costs no more than that."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ilf.blocks import Box

from .images import image_over
from .items import ViewItem

_FORMAT = QImage.Format.Format_RGBA8888_Premultiplied
"""One that Qt scales exactly, pixel by pixel; of others it has quicker ways that are off by one here and there."""
Pixels = NDArray[np.uint32]
"""Premultiplied colours, each at most as large as alpha."""


class PixelItem(ViewItem):
    """Picture in image coordinates, one unit per pixel.

    Attributes
    ----------
    image : ndarray or None
        What the picture was made of: colour (H, W, 3), indices (H, W) or numbers as `packed`; None for no picture.
    pixels : ndarray of uint32, shape (H, W)
        What is drawn. After a change in place, `note_change` says where.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.image: NDArray[np.uint8] | Pixels | None = None
        self.pixels: Pixels = np.zeros((0, 0), np.uint32)
        self._drawn = QImage()
        self._span: tuple[int, int] | None = None
        self._table: Pixels = np.zeros(256, np.uint32)
        self._grey: Pixels = np.zeros(256, np.uint32)

    def set_rgb(self, rgb: NDArray[np.uint8]) -> None:
        """Show colour, uint8 (H, W, 3), red first."""
        pixels = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2RGBA).view(np.uint32)[..., 0]
        self._show(rgb, pixels)

    def set_indices(
        self, indices: NDArray[np.uint8], table: NDArray[np.uint8], faded: NDArray[np.bool_] | None = None
    ) -> None:
        """Show indices, uint8 (H, W), through a table of RGBA, uint8 (256, 4), in grey where `faded`, bool (H, W)."""
        self._table = packed(table)
        self._grey = greyed(self._table)
        # a copy, to be changed in place by `update_indices`
        own = np.array(indices)
        self._show(own, self._coloured(own, faded))

    def update_indices(self, box: Box, indices: NDArray[np.uint8], faded: NDArray[np.bool_] | None = None) -> None:
        """Other indices inside a box (rows, columns), through the same table."""
        if self.image is not None:
            self.image[box] = indices
            self.pixels[box] = self._coloured(indices, faded)
            self.note_change(box)

    def _coloured(self, indices: NDArray[np.uint8], faded: NDArray[np.bool_] | None) -> Pixels:
        colours = self._table[indices]
        if faded is not None and faded.any():
            colours[faded] = self._grey[indices[faded]]
        return colours

    def set_pixels(self, pixels: Pixels) -> None:
        """Show an array, uint32 (H, W), which the caller may change in place."""
        self._show(pixels, pixels)

    def set_span(self, span: tuple[int, int] | None) -> None:
        """Show just the columns from the first to before the second; None for all."""
        if span != self._span:
            self._span = span
            self.update()

    def note_change(self, box: Box) -> None:
        """The pixels have changed inside a box (rows, columns)."""
        rows, columns = box
        self.update(QRectF(columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start))

    def clear(self) -> None:
        """Show nothing."""
        if self.image is not None:
            self.image, self._drawn = None, QImage()
            self.set_extent(None)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        # all of it: what need not be drawn is clipped, and a part would be rounded to other places on the screen
        rect = self.boundingRect()
        if self._span is None:
            painter.drawImage(rect, self._drawn)
            return
        left, right = self._span
        painter.save()
        painter.setClipRect(QRectF(left, 0, right - left, rect.height()), Qt.ClipOperation.IntersectClip)
        painter.drawImage(rect, self._drawn)
        painter.restore()

    def _show(self, image: NDArray[np.uint8] | Pixels, pixels: Pixels) -> None:
        self.image, self.pixels = image, np.ascontiguousarray(pixels)
        self._drawn = image_over(self.pixels, _FORMAT)
        self.set_extent(QRectF(0, 0, self._drawn.width(), self._drawn.height()))


def packed(table: NDArray[np.uint8]) -> Pixels:
    """Colours, uint8 (N, 4) RGBA, as the N numbers that `PixelItem.pixels` are made of: premultiplied, red lowest."""
    colours = table.astype(np.uint32)
    alpha = colours[:, 3]
    red, green, blue = ((colours[:, channel] * alpha + 127) // 255 for channel in range(3))
    return ((alpha << 24) | (blue << 16) | (green << 8) | red).astype(np.uint32)


def greyed(colours: Pixels) -> Pixels:
    """Opaque or clear colours with most of their hue taken out, a little towards the middle."""
    red, green, blue = (colours & 255, (colours >> 8) & 255, (colours >> 16) & 255)
    grey = (red * 2 + green * 5 + blue) // 8
    faded = [(channel + 4 * grey + 2 * 128) // 7 for channel in (red, green, blue)]
    mixed = (colours & 0xFF000000) | (faded[2] << 16) | (faded[1] << 8) | faded[0]
    return np.where(colours >> 24 > 0, mixed, 0).astype(np.uint32)
