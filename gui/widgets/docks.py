"""The dock panels of the window: places, visibility and sizes; the size of the window on the screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from PySide6.QtCore import QByteArray, QEvent, QObject, QRect, QSettings, QSize, Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtWidgets import QDockWidget, QMainWindow, QToolBar, QWidget

from ..base import theme

DEFAULT_SIZE = QSize(1440, 900)
_FRAME = QSize(0, 40)
"""Space for the window frame of the system."""
_VERSION = 1
"""Version of the stored layout; layouts of other versions are ignored."""
_COLUMN = 0.26, 270, 380
"""Width of the panel column: share of the window, minimum and maximum [px]."""
_BELOW = 110
"""Height of panels below the images [px], times their relative height."""
_MIN_HEIGHT = 100
"""Minimum window height [px] per panel of a column, times its relative height; with less, panels share a place in
tabs."""
_MIN_AUTO_HEIGHT = 760
"""Minimum height of a window [px] in which panels open automatically."""

_RAIL_ICON = 20


class _Panel(NamedTuple):
    dock: QDockWidget
    icon: str
    height: float


class Docks(QObject):
    """The panels around the centre of a window, and the icon bar at its side that shows and hides them.

    A panel that the user has hidden does not open automatically until the user shows it again.

    Parameters
    ----------
    window : QMainWindow
    persistent : bool
        Whether window size and hidden panels are restored from the last session and stored for the next.
    """

    def __init__(self, window: QMainWindow, persistent: bool) -> None:
        super().__init__(window)
        self._window = window
        self.persistent = persistent
        self._arranged = False
        self._panels: dict[str, _Panel] = {}
        self._open_by_default: list[str] = []
        self._last_open: list[str] = []
        self._hidden_by_user: set[str] = set()
        self._sized: set[str] = set()
        self._declared = QByteArray()
        self._requested: tuple[list[str] | None, bytes] = None, b""
        """Panels and layout that were requested before the window was shown."""
        window.setDockOptions(QMainWindow.DockOption.AnimatedDocks | QMainWindow.DockOption.AllowTabbedDocks)
        self.rail = QToolBar("Panels", window)
        self.rail.setObjectName("Panels")
        self.rail.setMovable(False)
        self.rail.setIconSize(QSize(_RAIL_ICON, _RAIL_ICON))
        window.addToolBar(Qt.ToolBarArea.RightToolBarArea, self.rail)

    def add_fold(self, fold: QAction) -> None:
        """Add the action that hides all panels, before the panels are added."""
        self.rail.addAction(fold)
        self.rail.addSeparator()

    def add(
        self,
        title: str,
        widget: QWidget,
        area: Qt.DockWidgetArea,
        icon: str,
        height: float = 1.0,
        is_open: bool = False,
    ) -> None:
        """Add a panel.

        Parameters
        ----------
        title : str
        widget : QWidget
            Its content.
        area : Qt.DockWidgetArea
            Its default place.
        icon : str
            Icon in the icon bar ("ph.stack").
        height : float
            Relative height: to other panels of its column; below the images, to the default height.
        is_open : bool
            Whether it is open at the first start.
        """
        dock = QDockWidget(title, self._window)
        dock.setObjectName(title)
        dock.setWidget(widget)
        dock.installEventFilter(self)
        self._window.addDockWidget(area, dock)
        self._panels[title] = _Panel(dock, icon, height)
        if is_open:
            self._open_by_default.append(title)
        dock.setVisible(is_open)
        action = dock.toggleViewAction()
        action.setToolTip(f"Show or hide the panel {title}")
        action.triggered.disconnect()  # the default handler shows the dock before it has its place
        action.triggered.connect(lambda on: self.reveal(title) if on else dock.close())
        action.setIcon(theme.icon(icon, self._window.palette()))
        self.rail.addAction(action)

    def toggles(self) -> list[QAction]:
        """Return the actions that show and hide the panels, in the order in which they were added."""
        return [panel.dock.toggleViewAction() for panel in self._panels.values()]

    def draw_icons(self, palette: QPalette) -> None:
        """Redraw the icons in the colours of a palette."""
        for panel in self._panels.values():
            panel.dock.toggleViewAction().setIcon(theme.icon(panel.icon, palette))

    @property
    def open(self) -> list[str]:
        """Titles of the open panels, including those behind other tabs."""
        return [title for title, panel in self._panels.items() if not panel.dock.isHidden()]

    def offer(self, title: str) -> None:
        """Show a panel automatically, unless the user has hidden it or all panels, or the window is too small."""
        if title not in self._hidden_by_user and self.open and self._window.height() >= _MIN_AUTO_HEIGHT:
            self._show([*self.open, title])

    def reveal(self, title: str) -> None:
        """Show a panel on request of the user, in front of other tabs of its place."""
        self._share_place(title)  # before it is shown: a column higher than the window would enlarge the window
        self._show([*self.open, title])
        self._decide(title, True)

    def toggle_all(self) -> None:
        """Hide all panels, or show those again that were hidden so."""
        if self.open:
            self._last_open = self.open
            self._show([])
        else:
            self._show(self._last_open or self._open_by_default)

    def places(self) -> bytes:
        """Return the layout: places, sizes and visibility of the panels."""
        return bytes(self._window.saveState(_VERSION).data()) if self._arranged else self._requested[1]

    def take(self, titles: Iterable[str] | None, places: bytes = b"") -> None:
        """Show only these panels; None for the default ones.

        Parameters
        ----------
        titles : iterable of str, optional
            Unknown titles are ignored.
        places : bytes
            A layout from `places`; if empty or of another version, the default places are used.
        """
        wanted = self._open_by_default if titles is None else list(titles)
        if not self._arranged:  # docks take sizes only in a shown window
            self._requested = wanted, places
            self._show(wanted)
            return
        if places and self._window.restoreState(QByteArray(places), _VERSION):
            self._sized = set(wanted)
            self._show(wanted)
            return
        self._window.restoreState(self._declared, _VERSION)
        self._sized.clear()
        self._show(wanted)

    def allow_hidden(self) -> None:
        """Let all panels open automatically again."""
        self._hidden_by_user.clear()

    def size_window(self) -> None:
        """Restore the window's last size and place, or use the default ones, limited to the screen."""
        geometry = QSettings().value("window/geometry") if self.persistent else None
        if not isinstance(geometry, QByteArray) or not self._window.restoreGeometry(geometry):
            self._window.resize(DEFAULT_SIZE)
        if not self._window.isFullScreen() and not self._window.isMaximized():
            room = available_geometry(self._window)
            fitted = fit(self._window.geometry(), room)
            if fitted != self._window.geometry():
                self._window.setGeometry(fitted)

    def arrange(self) -> None:
        """Apply the layout that was requested before the window was shown. Works only once."""
        if self._arranged:
            return
        self._arranged = True
        self._declared = self._window.saveState(_VERSION)
        if self.persistent:
            self._hidden_by_user = set(_titles(QSettings().value("panels/declined")))
        self.take(*self._requested)

    def remember(self) -> None:
        """Store window size and hidden panels for the next session."""
        if self.persistent:
            QSettings().setValue("window/geometry", self._window.saveGeometry())
            QSettings().setValue("panels/declined", sorted(self._hidden_by_user))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Note panels that the user hides by the button in their title."""
        if event.type() == QEvent.Type.Close and isinstance(watched, QDockWidget):
            self._decide(watched.objectName(), False)
        return super().eventFilter(watched, event)

    def _decide(self, title: str, is_open: bool) -> None:
        """Note that the user showed or hid a panel."""
        if not is_open:
            self._hidden_by_user.add(title)
            return
        self._hidden_by_user.discard(title)
        self._share_place(title)
        self._panels[title].dock.raise_()
        self._size_new()

    def _share_place(self, title: str) -> None:
        """Tab a panel with the one above it in its column if the panels would be too low otherwise."""
        dock, window = self._panels[title].dock, self._window
        area = window.dockWidgetArea(dock)
        if dock.isFloating() or area == Qt.DockWidgetArea.BottomDockWidgetArea or window.tabifiedDockWidgets(dock):
            return
        column = [
            panel.dock
            for panel in self._panels.values()
            if (panel.dock is dock or not (panel.dock.isHidden() or panel.dock.isFloating()))
            and window.dockWidgetArea(panel.dock) == area
        ]
        above = column[: column.index(dock)] if dock in column else []
        heights: dict[QDockWidget, float] = {}
        for one in column:
            place = next((tab for tab in window.tabifiedDockWidgets(one) if tab in heights), one)
            heights[place] = max(heights.get(place, 0.0), self._panels[one.objectName()].height)
        if above and _MIN_HEIGHT * sum(heights.values()) > window.height():
            window.tabifyDockWidget(above[-1], dock)

    def _show(self, titles: Iterable[str]) -> None:
        wanted = set(titles)
        for title, panel in self._panels.items():
            if panel.dock.isHidden() == (title in wanted):
                panel.dock.setVisible(title in wanted)
        self._size_new()

    def _size_new(self) -> None:
        """Set default sizes if panels are open for the first time in this layout; a column keeps its width."""
        if self._arranged and not self._sized.issuperset(self.open):
            self._set_sizes(self.open)

    def _set_sizes(self, titles: list[str]) -> None:
        before = self._sized.copy()
        self._sized.update(titles)
        docks = [self._panels[title].dock for title in titles]
        share, least, most = _COLUMN
        width = min(max(round(share * self._window.width()), least), most)
        for area in (Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea):
            column = [dock for dock in docks if self._window.dockWidgetArea(dock) == area and not dock.isFloating()]
            heights = [round(100 * self._panels[dock.objectName()].height) for dock in column]
            if before.isdisjoint(dock.objectName() for dock in column):
                self._window.resizeDocks(column, [width] * len(column), Qt.Orientation.Horizontal)
            self._window.resizeDocks(column, heights, Qt.Orientation.Vertical)
        below = [dock for dock in docks if self._window.dockWidgetArea(dock) == Qt.DockWidgetArea.BottomDockWidgetArea]
        heights = [round(_BELOW * self._panels[dock.objectName()].height) for dock in below]
        self._window.resizeDocks(below, heights, Qt.Orientation.Vertical)


def _titles(value: object) -> list[str]:
    """Return a list of strings from settings, which store a single one as a string and none as nothing."""
    if isinstance(value, str):
        return [value]
    return [str(title) for title in value] if isinstance(value, list) else []


def available_geometry(window: QWidget) -> QRect:
    """Return the part of the screen that is available to windows."""
    return window.screen().availableGeometry()


def fit(window: QRect, room: QRect) -> QRect:
    """Return the window's inner geometry, limited to the room minus its frame and moved into it."""
    size = window.size().boundedTo(room.size() - _FRAME)
    left = min(max(window.left(), room.left()), room.right() + 1 - size.width())
    top = min(max(window.top(), room.top() + _FRAME.height()), room.bottom() + 1 - size.height())
    return QRect(left, top, size.width(), size.height())
