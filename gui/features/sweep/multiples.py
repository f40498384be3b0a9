"""Small multiples: a picture for every tested value, all in one colour scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, QRect, QSize, Qt, Signal
from PySide6.QtGui import QColor, QEnterEvent, QImage, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QFrame, QGridLayout, QScrollArea, QWidget

from ilf.drawing.colours import to_indices

from ...base import theme
from ...views.pixel_items import rgb_image

PICTURE = QSize(176, 132)
"""Maximum size of a picture [px]."""
SMALL_PICTURE = QSize(128, 96)
"""Maximum size of a picture for pairs of values [px]."""
_LEAST_PICTURE = QSize(110, 40)
_GAP = 8
_RING = 2.5


class Scale(NamedTuple):
    """Colour scale: a lookup table (256, 4) for values from low to high; 0 is missing."""

    table: NDArray[np.uint8]
    low: float
    high: float


class Tile(QAbstractButton):
    """Picture with its value and error below; a click applies the value."""

    def __init__(self, caption: str, size: QSize) -> None:
        super().__init__()
        self.caption = caption
        self._size = size
        self.error_text = "…"
        self.best = ""
        self.present = False
        self._values: NDArray[np.float32] | None = None
        self._image = QImage()
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._describe()

    def sizeHint(self) -> QSize:
        return self._size + QSize(0, 2 * self.fontMetrics().height() + 6)

    def set_values(self, values: NDArray[np.float32] | None, scale: Scale | None) -> None:
        """Draw these values, float32 (h, w), NaN = missing; None for nothing yet."""
        self._values = values
        if values is None or scale is None:
            self._image = QImage()
        else:
            self._image = rgb_image(scale.table[to_indices(values, scale.low, scale.high)][..., :3])
        self.update()

    def set_marks(self, error_text: str, best: str, present: bool) -> None:
        """Set the error, "best" or "equal" if it is one of the best, and whether it is the current value."""
        if (error_text, best, present) != (self.error_text, self.best, self.present):
            self.error_text, self.best, self.present = error_text, best, present
            self._describe()
            self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        colours = theme.colours(self.palette())
        painter = QPainter(self)
        line = self.fontMetrics().height()
        room = self.rect().adjusted(3, 3, -3, -(2 * line + 5))
        if self._image.isNull():
            painter.fillRect(room, colours.background)
        else:
            size = self._image.size().scaled(room.size(), Qt.AspectRatioMode.KeepAspectRatio)
            where = QRect(room.topLeft(), size)
            where.moveCenter(room.center())
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(where, self._image)
        marks = [mark for mark in (self.best, "current" * self.present) if mark]
        mark = f" ({', '.join(marks)})" if marks else ""
        colour = colours.good if self.best else colours.text
        for text, tone, row in ((self.caption, colours.text, 0), (self.error_text + mark, colour, 1)):
            painter.setPen(tone)
            where = QRect(3, room.bottom() + 3 + row * line, self.width() - 6, line)
            shown = self.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, where.width())
            painter.drawText(where, Qt.AlignmentFlag.AlignHCenter, shown)
        frame = self._frame(colours)
        if frame is not None:
            painter.setPen(frame)
            painter.drawRoundedRect(self.rect().adjusted(1, 1, -2, -2), 3, 3)

    def _frame(self, colours: theme.Colours) -> QPen | None:
        if self.best:
            return QPen(colours.good, _RING)
        if self.hasFocus() or self.underMouse():
            return QPen(colours.accent, 1.5)
        return QPen(colours.muted, 1.5, Qt.PenStyle.DashLine) if self.present else None

    def enterEvent(self, event: QEnterEvent) -> None:
        self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self.update()

    def _describe(self) -> None:
        marks = [mark for mark in (self.best, "current" * self.present) if mark]
        text = ", ".join([self.caption, self.error_text, *marks])
        self.setAccessibleName(text)
        self.setToolTip(f"{text}. Click to apply.")


class Multiples(QScrollArea):
    """Tiles in the order of the values, in as many columns as fit.

    Signals
    -------
    taken(int)
        The tile that was clicked.
    """

    taken = Signal(int)

    def __init__(self) -> None:
        super().__init__()
        self.tiles: list[Tile] = []
        self._scale: Scale | None = None
        self._pictures: dict[int, NDArray[np.float32]] = {}
        self._columns = 0
        self._rows = 0
        self._content = QWidget()
        self._grid = QGridLayout(self._content)
        self._grid.setContentsMargins(_GAP, _GAP, _GAP, _GAP)
        self._grid.setSpacing(_GAP)
        self.setWidget(self._content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setAccessibleName("Pictures of the values")

    def set_captions(self, captions: Sequence[str], shape: QSize = PICTURE, rows: int = 0) -> None:
        """Create a tile for every value, for pictures of that shape.

        With `rows`, tiles are in columns of that many, from below, as in the grid of errors.
        """
        room = SMALL_PICTURE if rows else PICTURE
        size = shape.scaled(room, Qt.AspectRatioMode.KeepAspectRatio).expandedTo(_LEAST_PICTURE)
        for tile in self.tiles:
            self._grid.removeWidget(tile)
            tile.hide()
            tile.deleteLater()
        self._pictures.clear()
        self.tiles = [Tile(caption, size) for caption in captions]
        for number, tile in enumerate(self.tiles):
            tile.clicked.connect(lambda _=False, number=number: self.taken.emit(number))
        self._columns, self._rows = 0, rows
        self._arrange()

    def set_pictures(self, pictures: Mapping[int, NDArray[np.float32]], scale: Scale) -> None:
        """Set the values, float32 (h, w), of some tiles, NaN = missing, and the common colour scale."""
        same = self._scale is not None and self._scale[1:] == scale[1:] and self._scale.table is scale.table
        for number, tile in enumerate(self.tiles):
            values = pictures.get(number)
            if not same or values is not self._pictures.get(number):
                tile.set_values(values, scale)
        self._pictures, self._scale = dict(pictures), scale

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        room = self.viewport().width() - _GAP
        if not self.tiles:
            return
        fitting = max(room // (self.tiles[0].sizeHint().width() + _GAP), 1)
        columns = len(self.tiles) // self._rows if self._rows else fitting
        if columns == self._columns:
            return
        self._columns = columns
        for tile in self.tiles:
            self._grid.removeWidget(tile)
        for number, tile in enumerate(self.tiles):
            row, column = divmod(number, columns)
            if self._rows:
                column, row = number // self._rows, self._rows - 1 - number % self._rows
            self._grid.addWidget(tile, row, column, Qt.AlignmentFlag.AlignCenter)


def small(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Subsample a picture to at most twice its resolution on the screen."""
    height, width = values.shape
    stride = max(math.ceil(height / (2 * PICTURE.height())), math.ceil(width / (2 * PICTURE.width())))
    return np.ascontiguousarray(values[::stride, ::stride])


class ScaleBar(QWidget):
    """Horizontal colour bar of the pictures."""

    def __init__(self) -> None:
        super().__init__()
        self._scale: Scale | None = None
        self._unit = ""
        self.setFixedHeight(self.fontMetrics().height() + 6)
        self.setMinimumWidth(180)
        self.setAccessibleName("Colours of the pictures")

    def set_scale(self, scale: Scale | None, unit: str) -> None:
        """Show another scale; None for nothing."""
        self._scale, self._unit = scale, unit
        if scale is not None:
            text = f"From {_short(scale.low)} to {_short(scale.high)} {unit}"
            self.setAccessibleDescription(text)
            self.setToolTip(f"{text}; black: missing")
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._scale is None:
            return
        painter, metrics = QPainter(self), self.fontMetrics()
        ends = _short(self._scale.low), f"{_short(self._scale.high)} {self._unit}"
        left, right = (metrics.horizontalAdvance(text) + 6 for text in ends)
        bar = self.rect().adjusted(left, 3, -right, -3)
        row = np.ascontiguousarray(self._scale.table[None, 1:, :3])
        painter.drawImage(bar, rgb_image(row))
        painter.setPen(QColor(theme.colours(self.palette()).text))
        middle = bar.center().y() + (metrics.ascent() - metrics.descent()) / 2
        painter.drawText(QPointF(0, middle), ends[0])
        painter.drawText(QPointF(bar.right() + 6, middle), ends[1])


def _short(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
