"""Many points of one colour in a plot."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPaintEngine, QPainter, QPen
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget


class Dots(pg.GraphicsObject):
    """Points of one size on the screen at every zoom; on the screen they are made of hairline points, which Qt draws so
    quickly that thousands of them can follow a drag.

    Parameters
    ----------
    size : float
        Across [px].
    """

    def __init__(self, size: float) -> None:
        super().__init__()
        self._size = size
        self._colour = QColor()
        self.x: NDArray[np.float64] = np.zeros(0)
        self.y: NDArray[np.float64] = np.zeros(0)
        self._rect = QRectF()

    def set_colour(self, colour: QColor) -> None:
        """Take another colour."""
        self._colour = colour
        self.update()

    def set_points(self, x: NDArray[np.floating], y: NDArray[np.floating]) -> None:
        """Draw other points; all numbers are finite."""
        self.prepareGeometryChange()
        self.x, self.y = x.astype(np.float64), y.astype(np.float64)
        self._rect = QRectF()
        if x.size:
            self._rect.setCoords(self.x.min(), self.y.min(), self.x.max(), self.y.max())
        self.informViewBoundsChanged()
        self.update()

    def boundingRect(self) -> QRectF:
        return self._rect

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        to_screen = painter.worldTransform()
        x, y = self.x * to_screen.m11() + to_screen.dx(), self.y * to_screen.m22() + to_screen.dy()
        painter.resetTransform()
        if painter.paintEngine().type() == QPaintEngine.Type.Raster:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
            painter.setPen(QPen(self._colour, 0))
            x, y = (
                np.add.outer(offsets, values).ravel()
                for offsets, values in zip(self._offsets(painter), (x, y), strict=True)
            )
        else:
            painter.setPen(QPen(self._colour, self._size, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawPoints(pg.functions.arrayToQPolygonF(x, y))

    def _offsets(self, painter: QPainter) -> NDArray[np.float64]:
        """Where the device pixels of a dot are from its middle, shape (2, N); its corners are left out."""
        ratio = painter.device().devicePixelRatioF()
        across = max(round(self._size * ratio), 1)
        steps = np.arange(across) - (across - 1) / 2
        places = np.array(np.meshgrid(steps, steps)).reshape(2, -1)
        return places[:, np.hypot(*places) <= across / 2 + 0.3] / ratio
