"""Mapping of image pixels to screen pixels, for lines and stripes with the same width at every zoom."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ilf.data.label_map import Box

from .pixel_items import image_over
from .scene_items import ViewItem

Argb = NDArray[np.uint32]
"""Device pixels as Qt's premultiplied ARGB: 0xAARRGGBB, each colour at most as large as alpha."""

Rims = tuple[tuple[bool, bool], tuple[bool, bool]]


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
    """

    scale: float
    x: int
    y: int
    size: tuple[int, int]
    frame: tuple[int, int]

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

    def _pixels(self, start: int, view: int, frame: int) -> NDArray[np.intp]:
        first, last = max(start, 0), min(start + math.ceil(frame * self.scale), view)
        pixels = np.floor((np.arange(first, max(last, first)) + 0.5 - start) / self.scale).astype(np.intp)
        return pixels[pixels < frame]


# A picture in the scene made of screen pixels, not image pixels.

_FORMAT = QImage.Format.Format_ARGB32_Premultiplied


class ScreenItem(ViewItem):
    """Overlay of device pixels over the visible part of the frame, for one sampling."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self._pixels: Argb = np.zeros((0, 0), np.uint32)
        self._prepare: Callable[[], None] = lambda: None
        self._drawn = QImage()
        self._place = QPointF()
        self._sampling: Sampling | None = None

    @property
    def pixels(self) -> Argb:
        """What is shown."""
        self._prepare()
        return self._pixels

    def show_pixels(
        self, pixels: Argb, sampling: Sampling, ratio: float, prepare: Callable[[], None] = lambda: None
    ) -> None:
        """Show an array, uint32, of the sampling's shape, which the caller may change in place; `prepare` is called
        before it is looked at."""
        self._pixels, self._sampling, self._prepare = pixels, sampling, prepare
        self._drawn = image_over(pixels, _FORMAT)
        self._drawn.setDevicePixelRatio(ratio)
        self._place = QPointF(sampling.left, sampling.top) / ratio
        self.set_extent(QRectF(0, 0, *sampling.frame))

    def shows(self, pixels: Argb) -> bool:
        """Whether this array is shown."""
        return self._pixels is pixels

    def notify_change(self, box: Box) -> None:
        """Repaint after the pixels changed inside a box of the array."""
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
            self._pixels, self._drawn, self._prepare = np.zeros((0, 0), np.uint32), QImage(), lambda: None
            self.set_extent(None)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        self._prepare()
        painter.save()
        painter.resetTransform()
        painter.drawImage(self._place, self._drawn)
        painter.restore()
