"""The dock panels of the window, as groups of tabs at its right side; the size of the window on the screen."""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum

from PySide6.QtCore import QByteArray, QObject, QPoint, QSettings, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QDockWidget, QHBoxLayout, QMainWindow, QTabBar, QTabWidget, QWidget

from ..base import theme
from ..base.commands import HINT, describe
from .basics import PlainLabel, flat_button, lay_out

DEFAULT_SIZE = QSize(1440, 900)
_FRAME = QSize(0, 40)
"""Space for the window frame of the system."""
_GEOMETRY_KEY, _PLACE_KEY = "window/geometry", "window/place"
_VERSION = 3
"""Version of the stored layout; layouts of other versions are ignored."""
_COLUMN = 0.26, 270, 380
"""Width of the panel column: share of the window, minimum and maximum [px]."""
_LATE = 1.3
"""How many times as high a group is that is opened beside others: it is what the user looks at."""
_DRAG_MS = 50
"""How often it is looked whether a panel is still being moved [ms]."""
_MIN_HEIGHT = 60
"""Height [px] to which a panel can shrink, so that the panels never enlarge the window."""


class PanelTitle(QWidget):
    """The title of a panel that has no tab, with a button that closes it; dragging it moves the panel."""

    def __init__(self, dock: QDockWidget) -> None:
        super().__init__(dock)
        name, title = dock.windowTitle(), PlainLabel(dock.windowTitle())
        hint = f"Close the panel {name}; View > Panels opens it again"
        close = flat_button(hint, dock.close, name=f"Close {name}", icon="ph.x")
        close.setObjectName("close")
        close.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        lay_out(QHBoxLayout(self), title, close, margins=(8, 1, 2, 1), stretched=title)
        self.setToolTip("Drag the title, or double-click it, to move the panel out of the window")


class PanelGroup(Enum):
    """Panels of one purpose, which share one place as tabs. From top to bottom; the value is the relative height."""

    WORK = 2.2
    SETTINGS = 3.2
    INSPECTION = 2.6


class Docks(QObject):
    """The panels at the right side of a window, and the actions that show and hide them.

    No panel opens unless the user or a layout that the user has chosen opens it.

    Parameters
    ----------
    window : QMainWindow

    Signals
    -------
    turned()
        A panel was opened or closed.
    """

    turned = Signal()

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._placed = self._arranged = self._in_use = False
        self._docks: dict[str, QDockWidget] = {}
        self._groups: dict[QDockWidget, PanelGroup] = {}
        self._open_by_default: list[str] = []
        self._last_open: list[str] = []
        self._sized: set[PanelGroup] = set()
        self._declared = QByteArray()
        self._requested: tuple[list[str] | None, bytes] = None, b""
        """Panels and layout that were requested before the window was shown."""
        self._titles_timer = QTimer(self, singleShot=True, interval=0)  # tabs are made after a panel is shown
        self._titles_timer.timeout.connect(self._show_titles)
        window.setDockOptions(QMainWindow.DockOption.AllowTabbedDocks)
        window.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QTabWidget.TabPosition.North)

    def add(
        self, title: str, widget: QWidget, group: PanelGroup, icon: str, is_open: bool = False, content: str = ""
    ) -> None:
        """Add a panel.

        Parameters
        ----------
        title : str
        widget : QWidget
            Its content.
        group : PanelGroup
            The panels that it shares its place with.
        icon : str
            Icon in the menu ("ph.stack").
        is_open : bool
            Whether it is open at the first start.
        content : str
            Other words for what it shows, for its hint.
        """
        dock = QDockWidget(title, self._window)
        dock.setObjectName(title)
        widget.setMinimumHeight(_MIN_HEIGHT)
        policy = widget.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        widget.setSizePolicy(policy)
        dock.setWidget(widget)
        dock.visibilityChanged.connect(widget.setVisible)  # behind another tab, it is neither drawn nor a stop of Tab
        self._docks[title], self._groups[dock] = dock, group
        if self._placed:
            self._place(dock)
        if is_open:
            self._open_by_default.append(title)
        dock.setVisible(is_open)
        action = dock.toggleViewAction()
        action.setProperty(HINT, f"Show or hide the panel {title}" + (f": {content}" if content else ""))
        describe(action)
        action.triggered.disconnect()  # the default handler shows the dock behind the other tabs
        action.triggered.connect(lambda _=False: self._turn(title))
        action.toggled.connect(self.turned)
        for changed in (action.toggled, dock.topLevelChanged):
            changed.connect(self._show_titles_soon)
        action.setIcon(theme.icon(icon))

    def _place(self, dock: QDockWidget) -> None:
        """Put a panel below those of other groups, as the last tab of its own group."""
        others = [other for other, group in self._groups.items() if group is self._groups[dock]]
        before = others[: others.index(dock)]
        self._window.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, dock)
        if before:
            self._window.tabifyDockWidget(before[-1], dock)

    def toggles(self) -> list[QAction]:
        """Return the actions that show and hide the panels, in the order in which they were added."""
        return [dock.toggleViewAction() for dock in self._groups]

    @property
    def open(self) -> list[str]:
        """Titles of the open panels, including those behind other tabs."""
        return [title for title, dock in self._docks.items() if not dock.isHidden()]

    def reveal(self, title: str) -> None:
        """Show a panel on request of the user, in front of the other tabs of its place."""
        self._show([*self.open, title])
        self._docks[title].raise_()

    def enter(self, title: str) -> None:
        """Show a panel and give its first control the keyboard focus."""
        self.reveal(title)
        content = self._docks[title].widget()
        content.show()  # it is hidden until the tab has turned
        for control in (content, *content.findChildren(QWidget)):
            if control.isVisible() and control.isEnabled() and control.focusPolicy() & Qt.FocusPolicy.TabFocus:
                self._window.setAttribute(Qt.WidgetAttribute.WA_KeyboardFocusChange)  # buttons show the focus
                control.setFocus(Qt.FocusReason.ShortcutFocusReason)
                break

    def _turn(self, title: str) -> None:
        """Close a panel that is in sight, or show it."""
        dock = self._docks[title]
        if not dock.isHidden() and dock.widget().isVisible():
            dock.close()
        else:
            self.enter(title)
            dock.toggleViewAction().setChecked(True)  # the action of one behind another tab has switched itself off

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
        if not places or not self._window.restoreState(QByteArray(places), _VERSION):
            self._window.restoreState(self._declared, _VERSION)
            self._sized.clear()
            self._show(wanted)
            for title in reversed(self.open):  # the first one of each group in front
                self._docks[title].raise_()
            return
        self._sized = {self._groups[self._docks[title]] for title in wanted if title in self._docks}
        self._show(wanted)

    def place(self) -> None:
        """Place all panels, group by group, in whatever order they were added."""
        for dock in sorted(self._groups, key=lambda dock: list(PanelGroup).index(self._groups[dock])):
            self._place(dock)
        self._placed = True

    def size_window(self) -> None:
        """Restore the window's last size and place, or use the default size; both are limited to the screen."""
        window, geometry, place = self._window, QSettings().value(_GEOMETRY_KEY), QSettings().value(_PLACE_KEY)
        if not isinstance(geometry, QByteArray) or not window.restoreGeometry(geometry):
            window.resize(DEFAULT_SIZE.boundedTo(window.screen().availableSize() - _FRAME))
        elif isinstance(place, QPoint) and (window.pos() - place).manhattanLength() < _FRAME.height():
            window.move(place)  # at the top, Qt leaves room for a title bar of the height that it expects

    def arrange(self) -> None:
        """Apply the layout that was requested before the window was shown. Works only once."""
        self._in_use = True
        if self._arranged:
            return
        self._arranged = True
        self._show_titles_soon()
        self._declared = self._window.saveState(_VERSION)
        self.take(*self._requested)
        for dock in self._groups:
            if dock.isFloating() and not dock.isHidden():  # what is mapped before the window stays below it (X11)
                dock.hide()
                QTimer.singleShot(0, dock, dock.show)

    def remember(self) -> None:
        """Store the window size for the next session, when the window closes, and close what is outside it."""
        self._in_use = False
        self._titles_timer.stop()
        for dock in self._groups:
            if dock.isFloating():
                dock.hide()
        QSettings().setValue(_GEOMETRY_KEY, self._window.saveGeometry())
        QSettings().setValue(_PLACE_KEY, self._window.pos())

    def _show_titles_soon(self) -> None:
        if self._in_use:  # closing the window hides its panels
            self._titles_timer.start(0)

    def _show_titles(self) -> None:
        """Leave out the title of panels that have a tab with the same text; those outside the window have its frame."""
        for dock in self._groups:
            tabbed = any(not other.isHidden() for other in self._window.tabifiedDockWidgets(dock))
            wanted = QWidget if tabbed else None if dock.isFloating() else PanelTitle
            present = dock.titleBarWidget()
            if wanted is None and present is not None:
                if QApplication.mouseButtons():  # it may be being moved by its title, which must stay for that
                    self._titles_timer.start(_DRAG_MS)
                    continue
                dock.setTitleBarWidget(None)  # type: ignore[arg-type]
            elif wanted is not None and type(present) is not wanted:
                dock.setTitleBarWidget(wanted(dock))
            else:
                continue
            if present is not None:
                present.deleteLater()
        self._park_stray_tabs()

    def _park_stray_tabs(self) -> None:
        """Move tabs that Qt has left over the centre out of sight, as it does with others that it does not use; the Tab
        key passes over those that are out of sight."""
        centre = self._window.centralWidget()
        if centre is not None:
            for tabs in self._window.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
                tabs.setElideMode(Qt.TextElideMode.ElideNone)  # whole titles; arrows lead to those without room
                if tabs.geometry().intersects(centre.geometry()):
                    tabs.move(-tabs.width(), -tabs.height())
                is_in_sight = self._window.rect().intersects(tabs.geometry())
                tabs.setFocusPolicy(Qt.FocusPolicy.TabFocus if is_in_sight else Qt.FocusPolicy.NoFocus)

    def _show(self, titles: Iterable[str]) -> None:
        wanted = set(titles)
        for title, dock in self._docks.items():
            if dock.isHidden() == (title in wanted):
                dock.setVisible(title in wanted)
        if self._arranged:
            self._size_new()

    def _size_new(self) -> None:
        """Set default sizes if a group is visible for the first time in this layout; a column keeps its width."""
        shown: dict[PanelGroup, QDockWidget] = {}
        for dock, group in self._groups.items():
            if not dock.isHidden() and not dock.isFloating():
                shown.setdefault(group, dock)
        if self._sized.issuperset(shown):
            return
        docks = list(shown.values())
        if self._sized.isdisjoint(shown):
            share, least, most = _COLUMN
            width = min(max(round(share * self._window.width()), least), most)
            self._window.resizeDocks(docks, [width] * len(docks), Qt.Orientation.Horizontal)
        late = set() if self._sized.isdisjoint(shown) else shown.keys() - self._sized
        heights = [round(100 * group.value * (_LATE if group in late else 1)) for group in shown]
        self._window.resizeDocks(docks, heights, Qt.Orientation.Vertical)
        self._sized.update(shown)
