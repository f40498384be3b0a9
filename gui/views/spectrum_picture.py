"""The spectrum of the selected block, with the pass band of its filter."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from ..base import theme
from .colours import strength_table
from .image_view import FOCUS_WIDTH, ImageView
from .layers import BAND
from .pixel_items import image_over, packed
from .view_data import Spectrum

_HALO = QColor(0, 0, 0, 170)
_MARGIN = 8
_MIN_RADIUS = 3.0
"""Minimum radius of a drawn pass band [screen px]."""


class SpectrumPicture(QWidget):
    """Widget over a view: a spectrum has no pixels of the frame, so it has no pan, zoom or cursor."""

    def __init__(self, view: ImageView) -> None:
        super().__init__(view)
        self._spectrum: Spectrum | None = None
        self._message = ""
        self._image = QImage()
        self.setAccessibleName("Spectrum of the selected block")
        view.resized.connect(self._cover)
        self._cover()
        self.show()

    def show_spectrum(self, spectrum: Spectrum | str) -> None:
        """Draw a spectrum, or show the reason why there is none."""
        self._spectrum = None if isinstance(spectrum, str) else spectrum
        self._message = spectrum if isinstance(spectrum, str) else ""
        if self._spectrum is not None:
            indices = 1 + np.round(254 * self._spectrum.magnitude).astype(np.uint8)
            self._image = image_over(packed(strength_table())[indices], QImage.Format.Format_RGBA8888).copy()
        self.update()

    def _cover(self) -> None:
        view = self.parentWidget()
        if view is not None:
            self.setGeometry(view.rect().adjusted(FOCUS_WIDTH, FOCUS_WIDTH, -FOCUS_WIDTH, -FOCUS_WIDTH))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter, colours = QPainter(self), theme.colours(self.palette())
        painter.fillRect(self.rect(), colours.background)
        painter.setPen(colours.muted)
        if self._spectrum is None:
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self._message)
            return
        height, width = self._spectrum.magnitude.shape
        room = QRectF(self.rect()).adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
        scale = min(room.width() / width, room.height() / height)
        place = QRectF(0, 0, width * scale, height * scale)
        place.moveCenter(room.center())
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, scale < 1)
        painter.drawImage(place, self._image)
        self._draw_band(painter, place, scale, self._spectrum)

    def _draw_band(self, painter: QPainter, place: QRectF, scale: float, spectrum: Spectrum) -> None:
        height, width = spectrum.magnitude.shape
        # k = 0 is the sample in the middle, as from `fftshift`
        centre = place.topLeft() + QPointF((width // 2 + 0.5) * scale, (height // 2 + 0.5) * scale)
        down, across = (max(radius * scale, _MIN_RADIUS) for radius in spectrum.radii)
        painter.setClipRect(place)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for colour, line in ((_HALO, 4.0), (BAND, 2.0)):
            painter.setPen(QPen(colour, line))
            painter.drawEllipse(centre, across, down)
