"""The frame over the view that has the keyboard focus."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QRegion, QResizeEvent
from PySide6.QtWidgets import QFrame, QWidget

from .image_view import ImageView

FOCUS_WIDTH = 2


class FocusFrame(QFrame):
    """Frame over a view in the theme's accent colour while it has the keyboard focus; it covers only its lines."""

    def __init__(self, parent: QWidget, view: ImageView) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()
        view.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the focus of the view."""
        if event.type() in (QEvent.Type.FocusIn, QEvent.Type.FocusOut):
            self.setVisible(event.type() == QEvent.Type.FocusIn)
        return False

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        inside = self.rect().adjusted(FOCUS_WIDTH, FOCUS_WIDTH, -FOCUS_WIDTH, -FOCUS_WIDTH)
        self.setMask(QRegion(self.rect()) - QRegion(inside))
