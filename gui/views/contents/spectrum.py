"""The spectrum of the chosen block, with the pass band that its filter lets through."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from gui.theme import Colours
from gui.views.colour_maps import strength_table
from gui.views.image_view import ImageView
from gui.views.pixel_item import packed
from gui.views.view_cell import ViewCell

from .material import Material, Spectrum
from .painter import Painter

_BAND, _HALO = QColor(90, 230, 255), QColor(0, 0, 0, 170)
_MARGIN = 8
_LEAST_RADIUS = 3.0
"""Pixels of the screen that a very narrow pass band has."""


class SpectrumPicture(QWidget):
    """Lies over a view: a spectrum has no pixels of the frame, and so no part in their pan, zoom and cursor."""

    def __init__(self, view: ImageView) -> None:
        super().__init__(view)
        self._spectrum: Spectrum | None = None
        self._message = ""
        self._image = QImage()
        self._background = self._text = QColor()
        self.setAccessibleName("Spectrum of the chosen block")
        view.resized.connect(self._cover)
        self._cover()
        self.show()

    def set_colours(self, colours: Colours) -> None:
        """Take the colours of the theme."""
        self._background, self._text = colours.background, colours.muted
        self.update()

    def show_spectrum(self, spectrum: Spectrum | str) -> None:
        """Draw a spectrum, or say why there is none."""
        self._spectrum = None if isinstance(spectrum, str) else spectrum
        self._message = spectrum if isinstance(spectrum, str) else ""
        if self._spectrum is not None:
            indices = 1 + np.round(254 * self._spectrum.magnitude).astype(np.uint8)
            pixels = packed(strength_table())[indices]
            height, width = pixels.shape
            self._image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
        self.update()

    def _cover(self) -> None:
        view = self.parentWidget()
        if view is not None:
            self.setGeometry(view.rect())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._background)
        painter.setPen(self._text)
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
        # k = 0 is the sample in the middle, as `fftshift` puts it
        centre = place.topLeft() + QPointF((width // 2 + 0.5) * scale, (height // 2 + 0.5) * scale)
        down, across = (max(radius * scale, _LEAST_RADIUS) for radius in spectrum.radii)
        painter.setClipRect(place)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for colour, line in ((_HALO, 4.0), (_BAND, 2.0)):
            painter.setPen(QPen(colour, line))
            painter.drawEllipse(centre, across, down)


class SpectrumPainter(Painter):
    """Log magnitude of the block's depth, and the last pass band."""

    uses = frozenset({"spectrum"})

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        super().__init__(content, cell, material)
        self._picture = SpectrumPicture(cell.view)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        self._picture.set_colours(colours)
        self.cell.set_legend([])

    def draw(self) -> None:
        spectrum = self.material.spectrum
        self._picture.show_spectrum(spectrum)
        there = not isinstance(spectrum, str)
        self.cell.strip.set_text(spectrum.text if isinstance(spectrum, Spectrum) else "")
        self.cell.set_legend([(QBrush(_BAND), "pass band")] if there else [])

    def leave(self) -> None:
        self._picture.hide()
        self._picture.setParent(None)
        self._picture.deleteLater()
