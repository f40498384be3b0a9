"""Names of blocks, each at a place well inside its block."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from ilf.drawing.inner_points import InnerPoint

from .items import ViewItem

_LEAST_ROOM = 5.0
"""A block has its name if it holds a circle of this radius on the screen [px]."""
_PAD = 3.0


class NamesItem(ViewItem):
    """Texts of one size on the screen, on plates that let them be read on any picture."""

    def __init__(self, z: float) -> None:
        super().__init__(z)
        self._texts: list[tuple[str, InnerPoint]] = []
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)

    @property
    def texts(self) -> list[str]:
        """What is written, if there is room for it."""
        return [text for text, _ in self._texts]

    def set_names(self, names: Mapping[int, str], points: Mapping[int, InnerPoint], frame: QRectF) -> None:
        """Write names by label at the inner points of their blocks, within the frame."""
        self._texts = [(names[label], point) for label, point in points.items() if label in names]
        metrics = QFontMetricsF(self._font)
        widest = max((metrics.horizontalAdvance(text) for text in self.texts), default=0.0)
        self.set_extent(frame if self._texts else None, widest / 2 + _PAD + metrics.height())

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        transform = painter.worldTransform()
        scale, metrics = transform.m11(), QFontMetricsF(self._font)
        painter.save()
        painter.resetTransform()
        painter.setFont(self._font)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for text, (x, y, radius) in self._texts:
            if radius * scale < _LEAST_ROOM:
                continue
            plate = QRectF(0, 0, metrics.horizontalAdvance(text) + 2 * _PAD, metrics.height())
            plate.moveCenter(transform.map(QPointF(x, y)))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(0, 0, 0, 150))
            painter.drawRoundedRect(plate, 3, 3)
            painter.setPen(QColor("white"))
            painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()
