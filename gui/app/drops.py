"""Files that are dragged onto the window: it takes them as copies, and shows that it would."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, QRectF, Qt
from PySide6.QtGui import QColor, QDragEnterEvent, QDropEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QApplication, QWidget

from ilf._runtime.formatting import counted

from ..base import theme

_COPY = Qt.DropAction.CopyAction
_BORDER = 4
_TINT = 40
"""Opacity of the colour over the window, of 255."""


class FileDrops(QWidget):
    """A frame around the window, to be seen while files are dragged over it.

    Files are taken as copies, whatever the sender proposes: after a move it may delete them. Nothing else in the
    program takes files: fields of text would, by the action that is proposed.

    Parameters
    ----------
    window : QWidget
        Which takes the files: it passes its events on.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.text = ""
        """What a drop would do."""
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()
        window.setAcceptDrops(True)
        application = QApplication.instance()
        if application is not None:
            application.installEventFilter(self)

    def enter(self, event: QDragEnterEvent) -> None:
        """Something is dragged onto the window: show whether it would be taken."""
        paths = _paths(event)
        if not paths:
            event.ignore()
            return
        event.setDropAction(_COPY)
        event.accept()
        name = paths[0].name or str(paths[0])
        self.text = "Drop to open " + (name if len(paths) == 1 else counted(len(paths), "item"))
        self.setGeometry(self._window.rect())
        self.raise_()
        self.show()

    def leave(self) -> None:
        """It has been dragged on, or dropped."""
        self.hide()

    def take(self, event: QDropEvent) -> list[Path]:
        """The files that are dropped; none if it is something else."""
        self.leave()
        paths = _paths(event)
        if paths:
            event.setDropAction(_COPY)
            event.accept()
        else:
            event.ignore()
        return paths

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keep files from all other widgets: what lies in the window leaves them to it."""
        if not isinstance(event, QDropEvent) or not watched.isWidgetType() or watched is self._window:
            return False
        if not event.mimeData().hasUrls():
            return False
        event.ignore()
        return True

    def paintEvent(self, event: QPaintEvent) -> None:
        """A frame, and in the middle what a drop would do."""
        colours = theme.colours(self.palette())
        tint = QColor(colours.accent)
        tint.setAlpha(_TINT)
        font = self.font()
        font.setPointSizeF(1.4 * font.pointSizeF())
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), tint)
        painter.setPen(QPen(colours.accent, _BORDER))
        half = _BORDER // 2
        painter.drawRect(self.rect().adjusted(half, half, -half, -half))
        painter.setFont(font)
        text = painter.fontMetrics().elidedText(self.text, Qt.TextElideMode.ElideMiddle, self.width() // 2)
        box = QRectF(painter.fontMetrics().boundingRect(text)).adjusted(-24, -14, 24, 14)
        box.moveCenter(QRectF(self.rect()).center())
        painter.setPen(QPen(colours.accent, 1))
        painter.setBrush(colours.panel)
        painter.drawRoundedRect(box, 6, 6)
        painter.setPen(colours.text)
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
        painter.end()


def _paths(event: QDropEvent) -> list[Path]:
    """Files and folders of this machine that can be copied."""
    if not event.possibleActions() & _COPY:
        return []
    return [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
