"""Files that are dropped on the window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QDropEvent, QWindow
from PySide6.QtWidgets import QApplication, QMainWindow

from ..widgets.basics import TAKES_FILES


class FileDrops(QObject):
    """Lets a window take files that are dragged to it, and keeps them from its fields.

    Files are always copied, never moved: after a move the sender may delete them. Other widgets do not accept files;
    text fields would, with the action that the sender proposes.
    """

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        window.setAcceptDrops(True)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusWindowChanged.connect(self._focus_window_changed)

    def _focus_window_changed(self, window: QWindow | None) -> None:
        """Filter the events of a window of the system, which drags enter before its widgets."""
        if window is not None:
            window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Reject files on all other widgets, so that the window gets them.

        The widgets are filtered from the first drag on: a filter of the whole program would be called for each event.
        """
        if not isinstance(event, QDropEvent):
            return False
        if not watched.isWidgetType():
            for widget in QApplication.allWidgets():
                if widget.acceptDrops() and widget is not self._window and not widget.property(TAKES_FILES):
                    widget.installEventFilter(self)
            return False
        if not event.mimeData().hasUrls():
            return False
        event.ignore()
        return True


def accepted(event: QDropEvent) -> list[Path]:
    """Accept the local files and folders of a drag or a drop, to be copied, and return them; none if there are none or
    the sender would only move them."""
    may_copy = event.possibleActions() & Qt.DropAction.CopyAction
    paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if may_copy and url.isLocalFile()]
    event.setAccepted(bool(paths))
    if paths:
        event.setDropAction(Qt.DropAction.CopyAction)
    return paths
