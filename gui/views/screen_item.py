"""A picture in the scene that is made of pixels of the screen, not of the image."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ilf.blocks import Box

from .images import image_over
from .items import ViewItem
from .sampling import Argb, Sampling

_FORMAT = QImage.Format.Format_ARGB32_Premultiplied


class ScreenItem(ViewItem):
    """Device pixels over those of the view that show the frame, for one way in which the frame lies there."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self.pixels: Argb = np.zeros((0, 0), np.uint32)
        self._drawn = QImage()
        self._place = QPointF()
        self._sampling: Sampling | None = None

    def show_pixels(self, pixels: Argb, sampling: Sampling, ratio: float) -> None:
        """Show an array, uint32, of the sampling's shape, which the caller may change in place."""
        self.pixels, self._sampling = pixels, sampling
        self._drawn = image_over(pixels, _FORMAT)
        self._drawn.setDevicePixelRatio(ratio)
        self._place = QPointF(sampling.left, sampling.top) / ratio
        self.set_extent(QRectF(0, 0, *sampling.frame))

    def note_change(self, box: Box) -> None:
        """The pixels have changed inside a box of the array."""
        where = self._sampling
        if where is not None:
            rows, columns = box
            scale = where.scale
            left, top = columns.start + where.left - where.x, rows.start + where.top - where.y
            size = (columns.stop - columns.start) / scale, (rows.stop - rows.start) / scale
            self.update(QRectF(left / scale, top / scale, *size))

    def clear(self) -> None:
        """Show nothing."""
        if not self._drawn.isNull():
            self.pixels, self._drawn = np.zeros((0, 0), np.uint32), QImage()
            self.set_extent(None)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        painter.save()
        painter.resetTransform()
        painter.drawImage(self._place, self._drawn)
        painter.restore()
