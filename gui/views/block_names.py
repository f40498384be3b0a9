"""Names of blocks, each at a place well inside its block."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

_LARGEST_SIDE = 480
"""Pixels that are looked at along the frame's longer side: names need no better place."""
_LEAST_ROOM = 5.0
"""A block has its name if it holds a circle of this radius on the screen [px]."""
_PAD = 3.0

InnerPoint = tuple[float, float, float]
"""Image coordinates x, y of the middle of a large circle inside a block, and its radius."""


def inner_points(labels: NDArray[np.int32]) -> dict[int, InnerPoint]:
    """Block label -> inner point, for a label map, int32 (H, W); very small blocks are left out."""
    step = max(-(-max(labels.shape) // _LARGEST_SIDE), 1)
    few = np.pad(np.ascontiguousarray(labels[step // 2 :: step, step // 2 :: step]), 1, constant_values=-1)
    inside = np.ones(few.shape, np.uint8)
    across, down = few[:, 1:] != few[:, :-1], few[1:] != few[:-1]
    inside[:, 1:][across] = 0
    inside[1:][down] = 0
    inside[few <= 0] = 0
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, 3).ravel()
    order = np.flatnonzero(distance)
    order = order[np.argsort(distance[order], kind="stable")]
    best = np.zeros(max(int(few.max()), 0) + 1, np.intp)
    best[few.ravel()[order]] = order  # the last, and so the farthest from the border, stays
    points = {}
    for label in np.flatnonzero(best):
        row, column = divmod(int(best[label]), few.shape[1])
        x, y = (column - 1) * step + step // 2 + 0.5, (row - 1) * step + step // 2 + 0.5
        points[int(label)] = x, y, float(distance[best[label]]) * step
    return points


class NamesItem(QGraphicsItem):
    """Texts of one size on the screen, on plates that let them be read on any picture."""

    def __init__(self, z: float) -> None:
        super().__init__()
        self._texts: list[tuple[str, InnerPoint]] = []
        self._rect = QRectF()
        self._font = QFont()
        self._font.setPointSizeF(self._font.pointSizeF() * 0.85)
        self.setZValue(z)

    @property
    def texts(self) -> list[str]:
        """What is written, if there is room for it."""
        return [text for text, _ in self._texts]

    def set_names(self, names: Mapping[int, str], points: Mapping[int, InnerPoint], frame: QRectF) -> None:
        """Write names by label at the inner points of their blocks, within the frame."""
        self.prepareGeometryChange()
        self._texts = [(names[label], point) for label, point in points.items() if label in names]
        self._rect = frame if self._texts else QRectF()
        self.update()

    def boundingRect(self) -> QRectF:
        return self._rect

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
