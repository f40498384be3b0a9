"""Small scene items with line widths in screen pixels at every zoom."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPixmap
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from ..base.theme import Colours, blend

_TILE = 8


class ViewItem(QGraphicsItem):
    """Scene item with an extent in image coordinates and a margin around it in screen pixels.

    Parameters
    ----------
    z : float
        Stacking order.
    """

    def __init__(self, z: float) -> None:
        super().__init__()
        self._extent: QRectF | None = None
        self._margin = 0.0
        self._pixel_size = 1.0
        self.setZValue(z)

    def set_extent(self, extent: QRectF | None, margin: float = 0.0) -> None:
        """Set the rectangle drawn in, plus `margin` screen pixels around it; None for nothing."""
        self._repaint_old_area()
        self._extent, self._margin = extent, margin
        self.update()

    def set_pixel_size(self, pixel_size: float) -> None:
        """Set the image pixels per screen pixel, for the margin."""
        if pixel_size != self._pixel_size:
            self._repaint_old_area()
            self._pixel_size = pixel_size

    def boundingRect(self) -> QRectF:
        if self._extent is None:
            return QRectF()
        reach = self._margin * self._pixel_size
        return self._extent.adjusted(-reach, -reach, reach, reach)

    def _repaint_old_area(self) -> None:
        """Repaint the area where the item is drawn now.

        Qt repaints the area where it last painted the item, but only later: if part of the view is painted before,
        because another view or an item above has changed, Qt takes the new area for the old one.
        """
        scene, bounds = self.scene(), self.boundingRect()
        if scene is not None and self.isVisible() and not bounds.isEmpty():
            scene.update(bounds)
        self.prepareGeometryChange()


class HaloPath(ViewItem):
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

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        for colour, width in ((self._halo, self._width + 2), (self._colour, self._width)):
            pen = QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.SquareCap, Qt.PenJoinStyle.MiterJoin)
            pen.setCosmetic(True)
            painter.setPen(pen)
            painter.drawPath(self.path)


class Hatch(ViewItem):
    """Rectangle of diagonal stripes of fixed size on the screen, visible where depth is missing."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self._brush = QBrush()

    def set_brush(self, brush: QBrush) -> None:
        # a copy: painting changes its transform
        self._brush = QBrush(brush)
        self.update()

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        inverse, _ = painter.worldTransform().inverted()
        # in screen scale, but moving with the picture
        self._brush.setTransform(inverse)
        painter.fillRect(self.boundingRect(), self._brush)


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
