"""Where the window's panels stand, how large they are, and how the window fits the screen."""

from __future__ import annotations

from PySide6.QtCore import QRect, QSettings, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

DEFAULT_SIZE = QSize(1440, 900)
_FRAME = QSize(0, 40)
"""Room for what the system puts around a window."""


class Docks:
    """The panels around the centre of a window.

    Parameters
    ----------
    remembers : bool
        Whether size and places are those of the last time, and are kept for the next.
    """

    def __init__(self, window: QMainWindow, remembers: bool) -> None:
        self._window = window
        self._remembers = remembers
        self._arranged = False
        self._docks: dict[str, QDockWidget] = {}
        window.setDockOptions(QMainWindow.DockOption.AnimatedDocks | QMainWindow.DockOption.AllowTabbedDocks)

    def add(self, title: str, widget: QWidget, area: Qt.DockWidgetArea, behind: str = "") -> None:
        """Add a panel; `behind` another one, as a tab."""
        dock = QDockWidget(title, self._window)
        dock.setObjectName(title)
        dock.setWidget(widget)
        self._window.addDockWidget(area, dock)
        self._docks[title] = dock
        if behind:
            self._window.tabifyDockWidget(self._docks[behind], dock)
            self._docks[behind].raise_()

    def toggles(self) -> list[QAction]:
        """What shows and hides the panels, in the order in which they were added."""
        return [dock.toggleViewAction() for dock in self._docks.values()]

    def size_window(self) -> None:
        """Give the window the size and place of the last time, or the default one, as far as the screen has room."""
        geometry = QSettings().value("window/geometry") if self._remembers else None
        if geometry is None or not self._window.restoreGeometry(geometry):
            self._window.resize(DEFAULT_SIZE)
        if not self._window.isFullScreen() and not self._window.isMaximized():
            room = available_geometry(self._window)
            fitted = fit(self._window.geometry(), room)
            if fitted != self._window.geometry():
                self._window.setGeometry(fitted)

    def arrange(self) -> None:
        """Take the last arrangement, or the default one: docks take sizes only in a shown window. Once."""
        if self._arranged:
            return
        self._arranged = True
        state = QSettings().value("window/state") if self._remembers else None
        if state is None or not self._window.restoreState(state):
            self._arrange()

    def remember(self) -> None:
        """Keep size and arrangement for the next time."""
        if self._remembers:
            settings = QSettings()
            settings.setValue("window/geometry", self._window.saveGeometry())
            settings.setValue("window/state", self._window.saveState())

    def _arrange(self) -> None:
        """Enough for the content of the panels where the window is large, a share of it where not."""
        width, height = self._window.width(), self._window.height()
        frames, blocks, right, curves = (
            self._docks[title] for title in ("Frames", "Blocks", "Parameters", "Convergence")
        )
        left_width, right_width = min(430, round(0.33 * width)), min(310, round(0.24 * width))
        self._window.resizeDocks([frames, right], [left_width, right_width], Qt.Orientation.Horizontal)
        self._window.resizeDocks([frames, blocks], [170, 600], Qt.Orientation.Vertical)
        self._window.resizeDocks([curves], [min(230, round(0.3 * height))], Qt.Orientation.Vertical)


def available_geometry(window: QWidget) -> QRect:
    """What the system leaves of the screen for windows."""
    return window.screen().availableGeometry()


def fit(window: QRect, room: QRect) -> QRect:
    """The window's inside, no larger than the room less its frame, and moved into it."""
    size = window.size().boundedTo(room.size() - _FRAME)
    left = min(max(window.left(), room.left()), room.right() + 1 - size.width())
    top = min(max(window.top(), room.top() + _FRAME.height()), room.bottom() + 1 - size.height())
    return QRect(left, top, size.width(), size.height())
