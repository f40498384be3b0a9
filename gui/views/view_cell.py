"""One cell of the linked views: a thin title strip with its legend, the picture and its colour bar."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QRect, Qt, Signal
from PySide6.QtGui import QBrush, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QWidget

from gui.theme import Colours

from .colour_bar import ColourBar
from .image_view import ImageView

EventHandler = Callable[[ImageView, QEvent], bool]

_PAD = 8
_SWATCH = 11
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


class TitleStrip(QWidget):
    """Small muted caption with a legend at its right; a double-click on it is signalled."""

    doubleClicked = Signal()

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.title = title
        self._legend: list[tuple[QBrush, str]] = []
        self._text = ""
        self._colours: Colours | None = None
        font = self.font()
        font.setPointSizeF(font.pointSizeF() * 0.9)
        self.setFont(font)
        self.setFixedHeight(self.fontMetrics().height() + 8)
        self.setToolTip("Double-click to show this view alone, and again to go back")

    def set_colours(self, colours: Colours) -> None:
        """Take the colours of the theme."""
        self._colours = colours
        self.update()

    @property
    def caption_end(self) -> int:
        """Where the caption ends and other things may begin, in pixels from the left."""
        return 2 * _PAD + self.fontMetrics().horizontalAdvance(self.title)

    def set_text(self, text: str) -> None:
        """What there is to say of the picture, at the right."""
        if text != self._text:
            self._text = text
            self.update()

    def set_legend(self, legend: list[tuple[QBrush, str]]) -> None:
        """Swatches and what they stand for, from left to right; those that there is no room for are left out."""
        self._legend = legend
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._colours is None:
            return
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._colours.panel)
        painter.setPen(self._colours.muted)
        metrics = self.fontMetrics()
        painter.drawText(self.rect().adjusted(_PAD, 0, 0, 0), Qt.AlignmentFlag.AlignVCenter, self.title)
        right = self.width() - _PAD
        painter.drawText(self.rect().adjusted(0, 0, -_PAD, 0), _RIGHT, self._text)
        if self._text:
            right -= metrics.horizontalAdvance(self._text) + _PAD + 2
        # other things in the strip stand right of the caption
        taken = max(self.caption_end, self.childrenRect().right() + _PAD)
        for brush, text in reversed(self._legend):
            left = right - metrics.horizontalAdvance(text)
            swatch = QRect(left - 5 - _SWATCH, (self.height() - _SWATCH) // 2, _SWATCH, _SWATCH)
            if swatch.left() < taken:
                return
            painter.drawText(QRect(left, 0, right - left + 1, self.height()), Qt.AlignmentFlag.AlignVCenter, text)
            painter.setBrush(brush)
            painter.drawRect(swatch.adjusted(0, 0, -1, -1))
            right = swatch.left() - _PAD - 2

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.doubleClicked.emit()


class ViewCell(QWidget):
    """Title strip over an image view, with its colour bar at the right.

    A view whose colours have no unit keeps an empty bar, so that the pictures of all cells line up.
    """

    def __init__(self, title: str, unit: str, on_event: EventHandler) -> None:
        super().__init__()
        self.strip = TitleStrip(title)
        self.view = ImageView(on_event)
        self.bar = ColourBar(unit)
        layout = QGridLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.strip, 0, 0, 1, 2)
        layout.addWidget(self.view, 1, 0)
        layout.addWidget(self.bar, 1, 1)

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Take the colours of the theme."""
        self.strip.set_colours(colours)
        self.view.set_colours(colours, hatch)
        self.bar.set_colours(colours)
