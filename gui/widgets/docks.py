"""Where the window's panels stand, which are open, and how the window fits the screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from PySide6.QtCore import QByteArray, QEvent, QObject, QRect, QSettings, QSize, Qt
from PySide6.QtGui import QAction, QPalette
from PySide6.QtWidgets import QDockWidget, QMainWindow, QToolBar, QWidget

from ..base import theme

DEFAULT_SIZE = QSize(1440, 900)
_FRAME = QSize(0, 40)
"""Room for what the system puts around a window."""
_VERSION = 1
"""Of the arrangement that is remembered: that of another version is not taken up."""
_COLUMN = 0.26, 270, 380
"""Width of the column of panels: share of the window, and bounds [px]."""
_BELOW = 110
"""Height of panels below the pictures [px], times their own."""
_LEAST = 100
"""Height of a window [px] that a panel of a column needs to be of use, times its own; with less, panels share a place
in tabs."""
_ROOMY = 760
"""Height of a window [px] in which panels may open by themselves."""

_RAIL_ICON = 20


class _Panel(NamedTuple):
    dock: QDockWidget
    icon: str
    height: float


class Docks(QObject):
    """The panels around the centre of a window, and the rail of icons at its side that opens and folds them.

    What the user has folded does not open by itself any more, until the user opens it.

    Parameters
    ----------
    window : QMainWindow
    fold : QAction
        What folds all panels; the first icon of the rail.
    remembers : bool
        Whether the window's size, and what the user has folded, are those of the last time, and are kept for the next.
    """

    def __init__(self, window: QMainWindow, fold: QAction, remembers: bool) -> None:
        super().__init__(window)
        self._window = window
        self.remembers = remembers
        self._arranged = False
        self._panels: dict[str, _Panel] = {}
        self._first: list[str] = []
        self._folded: list[str] = []
        self._declined: set[str] = set()
        self._sized: set[str] = set()
        self._declared = QByteArray()
        self._wanted: tuple[list[str] | None, bytes] = None, b""
        """What was to be taken before the window was shown."""
        window.setDockOptions(QMainWindow.DockOption.AnimatedDocks | QMainWindow.DockOption.AllowTabbedDocks)
        self.rail = QToolBar("Panels", window)
        self.rail.setObjectName("Panels")
        self.rail.setMovable(False)
        self.rail.setIconSize(QSize(_RAIL_ICON, _RAIL_ICON))
        self.rail.addAction(fold)
        self.rail.addSeparator()
        window.addToolBar(Qt.ToolBarArea.RightToolBarArea, self.rail)
        fold.triggered.connect(self.toggle_all)

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
            What it holds.
        area : Qt.DockWidgetArea
            Where it stands until the user moves it.
        icon : str
            Of the rail ("ph.stack").
        height : float
            Its share of a column that it stands in with others, over theirs; below the pictures, over the usual one.
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
            self._first.append(title)
        dock.setVisible(is_open)
        action = dock.toggleViewAction()
        action.setToolTip(f"{title}: open or fold this panel")
        action.triggered.disconnect()  # the dock's own way shows it before it has found its place
        action.triggered.connect(lambda on: self.reveal(title) if on else dock.close())
        action.setIcon(theme.icon(icon, self._window.palette()))
        self.rail.addAction(action)

    def toggles(self) -> list[QAction]:
        """What opens and folds the panels, in the order in which they were added."""
        return [panel.dock.toggleViewAction() for panel in self._panels.values()]

    def draw_icons(self, palette: QPalette) -> None:
        """Take the icons in the colours of a palette."""
        for panel in self._panels.values():
            panel.dock.toggleViewAction().setIcon(theme.icon(panel.icon, palette))

    @property
    def open(self) -> list[str]:
        """Titles of the open panels, those behind others in tabs included."""
        return [title for title, panel in self._panels.items() if not panel.dock.isHidden()]

    def offer(self, title: str) -> None:
        """Open a panel for what goes on, unless the user has folded it before, or has folded all of them, or there is
        too little room beside those that are open."""
        if title not in self._declined and self.open and self._window.height() >= _ROOMY:
            self._show([*self.open, title])

    def reveal(self, title: str) -> None:
        """Open a panel, as the user has asked for it, in front of those that it shares its place with."""
        self._share_place(title)  # before it is shown: a column that is too high for the window makes that larger
        self._show([*self.open, title])
        self._decide(title, True)

    def toggle_all(self) -> None:
        """Fold all panels, or open those again that were folded so."""
        if self.open:
            self._folded = self.open
            self._show([])
        else:
            self._show(self._folded or self._first)

    def places(self) -> bytes:
        """Where the panels stand, how large they are, and which are open."""
        return bytes(self._window.saveState(_VERSION).data()) if self._arranged else self._wanted[1]

    def take(self, titles: Iterable[str] | None, places: bytes = b"") -> None:
        """Open these panels and no others; None for those that are open from the first.

        Parameters
        ----------
        titles : iterable of str, optional
            Those that there are not are passed over.
        places : bytes
            As `places` gave them; empty, or of another version, for where the panels were added.
        """
        wanted = self._first if titles is None else list(titles)
        if not self._arranged:  # docks take sizes only in a shown window
            self._wanted = wanted, places
            self._show(wanted)
            return
        if places and self._window.restoreState(QByteArray(places), _VERSION):
            self._sized = set(wanted)
            self._show(wanted)
            return
        self._window.restoreState(self._declared, _VERSION)
        self._sized.clear()
        self._show(wanted)

    def forget_folded(self) -> None:
        """Let panels open by themselves again, whatever the user has folded."""
        self._declined.clear()

    def size_window(self) -> None:
        """Give the window the size and place of the last time, or the default one, as far as the screen has room."""
        geometry = QSettings().value("window/geometry") if self.remembers else None
        if not isinstance(geometry, QByteArray) or not self._window.restoreGeometry(geometry):
            self._window.resize(DEFAULT_SIZE)
        if not self._window.isFullScreen() and not self._window.isMaximized():
            room = available_geometry(self._window)
            fitted = fit(self._window.geometry(), room)
            if fitted != self._window.geometry():
                self._window.setGeometry(fitted)

    def arrange(self) -> None:
        """Arrange the panels as was asked for before the window was shown. Once."""
        if self._arranged:
            return
        self._arranged = True
        self._declared = self._window.saveState(_VERSION)
        if self.remembers:
            self._declined = set(_titles(QSettings().value("panels/declined")))
        self.take(*self._wanted)

    def remember(self) -> None:
        """Keep the window's size, and what the user has folded, for the next time."""
        if self.remembers:
            QSettings().setValue("window/geometry", self._window.saveGeometry())
            QSettings().setValue("panels/declined", sorted(self._declined))

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Hear of panels that are folded by the button in their title."""
        if event.type() == QEvent.Type.Close and isinstance(watched, QDockWidget):
            self._decide(watched.objectName(), False)
        return super().eventFilter(watched, event)

    def _decide(self, title: str, is_open: bool) -> None:
        """The user has opened or folded a panel."""
        if not is_open:
            self._declined.add(title)
            return
        self._declined.discard(title)
        self._share_place(title)
        self._panels[title].dock.raise_()
        self._size_new()

    def _share_place(self, title: str) -> None:
        """Put a panel of a column behind a tab with the one above it, if all of them would be too low to be of use."""
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
        if above and _LEAST * sum(heights.values()) > window.height():
            window.tabifyDockWidget(above[-1], dock)

    def _show(self, titles: Iterable[str]) -> None:
        wanted = set(titles)
        for title, panel in self._panels.items():
            if panel.dock.isHidden() == (title in wanted):
                panel.dock.setVisible(title in wanted)
        self._size_new()

    def _size_new(self) -> None:
        """Sizes for panels that are open for the first time as things are arranged, and for their neighbours; others
        keep theirs, and so does a column its width."""
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
    """A list of strings as settings give it: one alone comes as such, and none as nothing."""
    if isinstance(value, str):
        return [value]
    return [str(title) for title in value] if isinstance(value, list) else []


def available_geometry(window: QWidget) -> QRect:
    """What the system leaves of the screen for windows."""
    return window.screen().availableGeometry()


def fit(window: QRect, room: QRect) -> QRect:
    """The window's inside, no larger than the room less its frame, and moved into it."""
    size = window.size().boundedTo(room.size() - _FRAME)
    left = min(max(window.left(), room.left()), room.right() + 1 - size.width())
    top = min(max(window.top(), room.top() + _FRAME.height()), room.bottom() + 1 - size.height())
    return QRect(left, top, size.width(), size.height())
