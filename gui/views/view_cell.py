"""One cell of the linked views: a thin title strip with its legend, the picture, and the colour bar over it."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QBrush, QColor, QResizeEvent
from PySide6.QtWidgets import QVBoxLayout, QWidget

from gui.theme import Colours

from .colour_bar import ColourBar
from .image_view import ImageView
from .title_strip import TitleStrip

EventHandler = Callable[[ImageView, QEvent], bool]

_PAD = 6
_MISSING = QColor(230, 230, 230), Qt.BrushStyle.FDiagPattern
_DISTRUSTED = QColor(255, 144, 32), Qt.BrushStyle.BDiagPattern
_OUTSIDE = QColor(60, 140, 220), Qt.BrushStyle.BDiagPattern
_UNVOUCHED = QColor(128, 128, 128), Qt.BrushStyle.BDiagPattern
_BAR_MARGIN = 6
_BAR_SHARE = 0.62
"""Most of the picture's height that the colour bar takes."""
_BAR_HEIGHTS = (84, 240)
"""Least and largest height of the colour bar; a view with less room has none."""

_BAR_ROOM = 260
"""Width of a view [px] below which a bar would cover too much of the picture."""


class ViewCell(QWidget):
    """Title strip over an image view, whose colour bar lies over the picture's right side.

    The bar goes away while the cursor is at what it covers, in whichever view, and where the picture is small.
    """

    def __init__(self, on_event: EventHandler) -> None:
        super().__init__()
        self.strip = TitleStrip()
        self.view = ImageView(on_event)
        self.strip.titled.connect(self.view.setAccessibleName)
        self.bar = ColourBar(self)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.strip)
        layout.addWidget(self.view, 1)
        self.bar.raise_()
        self._legend: list[tuple[QBrush, str]] = []
        self._overlaid: list[tuple[QBrush, str]] = []

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Take the colours of the theme."""
        self.strip.set_colours(colours)
        self.view.set_colours(colours, hatch)
        self.bar.set_colours(colours)

    def set_legend(self, legend: list[tuple[QBrush, str]]) -> None:
        """What the picture's own colours stand for."""
        self._legend = legend
        self.strip.set_legend([*self._overlaid, *legend])

    def set_marks(self, missing: bool, outside: bool, distrusted: bool, unvouched: bool) -> None:
        """Which stripes lie over the picture, for the legend."""
        marks = (
            (missing, _MISSING, "missing"),
            (outside, _OUTSIDE, "outside view"),
            (distrusted, _DISTRUSTED, "distrusted"),
            (unvouched, _UNVOUCHED, "nothing vouches"),
        )
        self._overlaid = [(QBrush(colour, pattern), text) for on, (colour, pattern), text in marks if on]
        self.set_legend(self._legend)

    def show_cursor(self, pixel: tuple[int, int] | None) -> None:
        """Put the crosshair on a pixel (x, y); None hides it."""
        self.view.show_cursor(pixel)
        place = self.bar.geometry().translated(-self.view.pos()).adjusted(-_PAD, -_PAD, _PAD, _PAD)
        self.bar.set_faded(
            pixel is not None and place.contains(self.view.viewportTransform().map(QPointF(*pixel)).toPoint())
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # at once, and not when Qt comes to it: what the view shows depends on its size
        strip = self.strip.height()
        self.strip.setGeometry(0, 0, self.width(), strip)
        self.view.setGeometry(0, strip, self.width(), max(self.height() - strip, 0))
        least, most = _BAR_HEIGHTS
        room = self.view.height() - 2 * _BAR_MARGIN
        height = min(max(round(_BAR_SHARE * room), least), most)
        self.bar.setVisible(height <= room and self.width() >= _BAR_ROOM)
        self.bar.move(self.width() - self.bar.width() - _BAR_MARGIN, strip + _BAR_MARGIN)
        self.bar.setFixedHeight(height)
