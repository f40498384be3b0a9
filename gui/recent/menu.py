"""A menu of what was opened last."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMenu

from gui.inventory import PASSING, WHY_NOT
from gui.recent.store import Origin, RecentOrigins, is_missing, key_of, name_of
from gui.widgets.plain_text import as_it_is

_DIGITS = 9


class RecentMenu(QMenu):
    """An entry per origin, the last first, and what takes entries out.

    Parameters
    ----------
    title : str
    origins : RecentOrigins
    open : callable
        Opens an origin.
    window : QMainWindow
    """

    def __init__(
        self, title: str, origins: RecentOrigins, open: Callable[[Origin], object], window: QMainWindow
    ) -> None:
        super().__init__(title, window)
        self.setToolTipsVisible(True)
        self.aboutToShow.connect(self.fill)
        self._origins = origins
        self._open = open
        self._window = window
        self._entries: dict[str, QAction] = {}
        self._remove = self._action("Take the grey ones out of this list", origins.remove_missing)
        self._clear = self._action("Forget what was opened; no file is touched", origins.clear)
        self._clear.setText("&Clear this list")

    def note(self, origin: Origin) -> None:
        """This has been opened."""
        self._origins.note(origin)
        self._allow()  # the entries are made when they are looked at

    def fill(self) -> None:
        """Make the entries."""
        self.clear()
        for number, origin in enumerate(self._origins.origins, 1):
            self.addAction(self._entry(number, origin))
        missing = sum(map(is_missing, self._origins.origins))
        self._remove.setText(f"&Remove what is missing ({missing})")
        self._remove.setVisible(missing > 0)
        self.addSeparator()
        self.addActions([self._remove, self._clear])
        self._allow()

    def _allow(self) -> None:
        self.menuAction().setEnabled(bool(self._origins.origins))

    def _entry(self, number: int, origin: Origin) -> QAction:
        """The entry of an origin, once made always the same: whoever lists the commands may hold it."""
        key, gone = key_of(origin), is_missing(origin)
        action = self._entries.get(key)
        if action is None:
            action = self._entries[key] = self._action(key, lambda: self._open_key(key))
            action.setObjectName(f"recent {key}")
            action.setProperty(WHY_NOT, "Its files are not there any more.")
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action.setText(f"{text} (missing)" if gone else text)
        action.setEnabled(not gone)
        return action

    def _action(self, hint: str, do: Callable[[], None]) -> QAction:
        action = QAction(self._window)
        action.setToolTip(as_it_is(hint))
        action.setProperty(PASSING, True)
        action.triggered.connect(lambda: do())
        action.triggered.connect(lambda: self._allow())
        return action

    def _open_key(self, key: str) -> None:
        origin = next((origin for origin in self._origins.origins if key_of(origin) == key), None)
        if origin is not None:
            self._open(origin)
