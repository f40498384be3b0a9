"""A figure on white paper, as wide as there is room for, and what it shows below it."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPixmap, QResizeEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QVBoxLayout, QWidget

from gui import theme
from gui.widgets.messages import Message

_PAPER = QColor("#ffffff")
_EDGE = 10
"""Paper around the figure."""

_NARROWEST = 200


class FigureView(QScrollArea):
    """Shows a PNG file. Figures are drawn for white paper; in the dark they keep it.

    Signals
    -------
    zoom_wished()
        A double-click: large instead of fitting, or back.
    """

    zoom_wished = Signal()

    def __init__(self, path: Path, caption: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.path = path
        self._whole = False
        self.paper = _Paper(QImage(str(path)))
        self.paper.double_clicked.connect(self.zoom_wished)
        self._caption = Message()
        self._caption.say(caption)
        self._caption.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        content = QWidget()
        self._column = QVBoxLayout(content)
        self._column.setContentsMargins(14, 12, 14, 12)
        self._column.setSpacing(8)
        self._column.addWidget(self.paper, 0, Qt.AlignmentFlag.AlignLeft)
        self._column.addWidget(self._caption)
        self._column.addStretch()
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self._fit()

    @property
    def readable(self) -> bool:
        """Whether the file is a picture."""
        return not self.paper.image.isNull()

    def set_whole(self, whole: bool) -> None:
        """Show the figure pixel by pixel, to be scrolled, or as wide as the view."""
        self._whole = whole
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit again."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        margins = self._column.contentsMargins()
        # room for the scroll bar always: its coming and going would change the width that decides whether it comes
        room = self.width() - self.verticalScrollBar().sizeHint().width() - margins.left() - margins.right()
        self.paper.fit(None if self._whole else max(room, _NARROWEST))
        self._column.invalidate()  # it holds heights for the old width, and a fixed size alone does not tell it


class _Paper(QWidget):
    """The figure itself."""

    double_clicked = Signal()

    def __init__(self, image: QImage) -> None:
        super().__init__()
        self.image = image
        self._scaled = QPixmap()
        self.setToolTip("Double-click: actual size, and back")

    def fit(self, width: int | None) -> None:
        """Take a width at most, or the figure's own."""
        own = self.image.width() + 2 * _EDGE
        width = own if width is None else min(width, own)
        height = round((width - 2 * _EDGE) * self.image.height() / max(self.image.width(), 1)) + 2 * _EDGE
        if self.size() != QSize(width, height):
            self.setFixedSize(width, height)
            self._scaled = QPixmap()

    def event(self, event: QEvent) -> bool:
        """Scale anew for a screen with other pixels."""
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._scaled = QPixmap()
        return super().event(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Zoom."""
        self.double_clicked.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paper with rounded corners and a thin edge, and the figure in the screen's own pixels."""
        if self._scaled.isNull():
            size = (self.size() - QSize(2 * _EDGE, 2 * _EDGE)) * self.devicePixelRatioF()
            smooth = Qt.TransformationMode.SmoothTransformation
            scaled = self.image.scaled(size, Qt.AspectRatioMode.IgnoreAspectRatio, smooth)
            scaled.setDevicePixelRatio(self.devicePixelRatioF())
            self._scaled = QPixmap.fromImage(scaled)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(theme.colours(self.palette()).grid)
        painter.setBrush(_PAPER)
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 5, 5)
        painter.drawPixmap(_EDGE, _EDGE, self._scaled)
        painter.end()
