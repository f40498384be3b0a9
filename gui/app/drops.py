"""Files that are dropped on the window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QDragEnterEvent, QDropEvent, QWindow
from PySide6.QtWidgets import QApplication, QFrame, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted

from ..base import theme
from ..widgets.basics import TAKES_FILES, PlainLabel, lay_out

_COPY = Qt.DropAction.CopyAction
_BORDER = 4
_TINT = 40
"""Opacity of the colour over the window, of 255."""


class FileDrops(QFrame):
    """An overlay over the window, visible while files are dragged over it.

    Files are always copied, never moved: after a move the sender may delete them. Other widgets do not accept files;
    text fields would, with the action that the sender proposes.

    Parameters
    ----------
    window : QWidget
        The window that accepts the files; it forwards its drag events.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self.text = ""
        """The effect of a drop, for the user."""
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._effect = PlainLabel()
        lay_out(QVBoxLayout(self), self._effect).setAlignment(self._effect, Qt.AlignmentFlag.AlignCenter)
        self.hide()
        window.setAcceptDrops(True)
        application = QApplication.instance()
        if isinstance(application, QApplication):
            application.focusWindowChanged.connect(self._focus_window_changed)

    def enter(self, event: QDragEnterEvent) -> None:
        """Show whether dragged content would be accepted."""
        paths = _paths(event)
        if not paths:
            event.ignore()
            return
        event.setDropAction(_COPY)
        event.accept()
        name = paths[0].name or str(paths[0])
        self.text = "Drop to open " + (name if len(paths) == 1 else counted(len(paths), "item"))
        self._write()
        self.setGeometry(self._window.rect())
        self.raise_()
        self.show()

    def take(self, event: QDropEvent) -> list[Path]:
        """Return the dropped files; none if other content was dropped."""
        self.hide()
        paths = _paths(event)
        if paths:
            event.setDropAction(_COPY)
            event.accept()
        else:
            event.ignore()
        return paths

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

    def _write(self) -> None:
        """Write the effect of a drop into the middle, in the theme's colours."""
        colours, size = theme.colours(self.palette()), 1.4 * self.font().pointSizeF()
        accent, panel = colours.accent.name(), colours.panel.name()
        self.setStyleSheet(
            f"FileDrops {{ border: {_BORDER}px solid {accent}; background: #{_TINT:02x}{accent[1:]}; }}"
            f"QLabel {{ color: {colours.text.name()}; background: {panel}; border: 1px solid {accent}; "
            f"border-radius: 6px; padding: 14px 24px; font-size: {size}pt; }}"
        )
        self._effect.ensurePolished()
        room, metrics = self._window.width() // 2, self._effect.fontMetrics()
        self._effect.setText(metrics.elidedText(self.text, Qt.TextElideMode.ElideMiddle, room))


def _paths(event: QDropEvent) -> list[Path]:
    """Return the local files and folders that can be copied."""
    if not event.possibleActions() & _COPY:
        return []
    return [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
