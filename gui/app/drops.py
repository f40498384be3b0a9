"""Files that are dropped on the window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QDropEvent, QWindow
from PySide6.QtWidgets import QApplication, QMainWindow

from ilf._runtime.formatting import counted

from ..widgets.basics import TAKES_FILES

_COPY = Qt.DropAction.CopyAction


class FileDrops(QObject):
    """Lets a window take files that are dragged to it; while they are over it, its status bar says what a drop does.

    Files are always copied, never moved: after a move the sender may delete them. Other widgets do not accept files;
    text fields would, with the action that the sender proposes.

    Parameters
    ----------
    window : QMainWindow
    take : callable
        Called with the files and folders that were dropped.
    """

    def __init__(self, window: QMainWindow, take: Callable[[list[Path]], object]) -> None:
        super().__init__(window)
        self._window, self._take = window, take
        window.setAcceptDrops(True)
        window.installEventFilter(self)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusWindowChanged.connect(self._focus_window_changed)

    def _focus_window_changed(self, window: QWindow | None) -> None:
        """Filter the events of a window of the system, which drags enter before its widgets."""
        if window is not None:
            window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take files that are over the window, and reject them on all its fields, so that the window gets them.

        The fields are filtered from the first drag on: a filter of the whole program would be called for each event.
        """
        if watched is self._window and event.type() in (QEvent.Type.DragLeave, QEvent.Type.Drop):
            self._window.statusBar().clearMessage()
        if not isinstance(event, QDropEvent):
            return False
        if not watched.isWidgetType():
            for widget in QApplication.allWidgets():
                if widget.acceptDrops() and widget is not self._window and not widget.property(TAKES_FILES):
                    widget.installEventFilter(self)
            return False
        paths = _paths(event) if watched is self._window else []
        event.setAccepted(bool(paths))
        if paths:
            event.setDropAction(_COPY)
            what = paths[0].name or str(paths[0]) if len(paths) == 1 else counted(len(paths), "item")
            if event.type() == QEvent.Type.Drop:
                self._take(paths)
            else:
                self._window.statusBar().showMessage(f"Drop to open {what}")
        return watched is self._window or event.mimeData().hasUrls()


def _paths(event: QDropEvent) -> list[Path]:
    """Return the local files and folders that can be copied."""
    if not event.possibleActions() & _COPY:
        return []
    return [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
