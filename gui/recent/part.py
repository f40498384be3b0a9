"""The menu of what was opened last."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from gui import theme
from gui.desk import Desk, Part
from gui.inventory import PASSING, WHY_NOT
from gui.menus import insert_menu
from gui.recent.store import Origin, RecentFrames, is_missing, key_of, name_of
from ilf.io.frame_source import FrameSource

_DIGITS = 9


class RecentPart(Part):
    """Notes what is opened, and opens it again, read in the same way."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.frames = RecentFrames(desk.panels.remembers)
        self._noted: set[str] = set()
        self.menu = QMenu("Open re&cent", desk.window)
        self.menu.setToolTipsVisible(True)
        self.menu.aboutToShow.connect(self._fill)
        self._entries: dict[str, QAction] = {}
        self._remove = self._action("Take the grey ones out of this list", self.frames.remove_missing)
        self._clear = self._action("Forget what was opened; no file is touched", self.frames.clear)
        self._clear.setText("&Clear this list")
        desk.workspace.sessions_changed.connect(self._note)

    def begin(self) -> None:
        """Stand in the menu beside what opens frames otherwise."""
        self.menu.setIcon(theme.icon("ph.clock-counter-clockwise", self.menu.palette()))
        insert_menu(self.desk.window.menuBar(), self.menu, self.desk.actions["open_run"])
        self._fill()

    def _note(self) -> None:
        """Note what has been opened since the last time."""
        open_now = {session.key: session.origin for session in self.desk.workspace.sessions}
        for key, origin in open_now.items():
            if key not in self._noted and isinstance(origin, FrameSource | Path):
                self.frames.note(origin)
        self._noted = set(open_now)
        self._allow()  # the entries are made when they are looked at

    def _fill(self) -> None:
        self.menu.clear()
        for number, origin in enumerate(self.frames.origins, 1):
            self.menu.addAction(self._entry(number, origin))
        missing = sum(map(is_missing, self.frames.origins))
        self._remove.setText(f"&Remove what is missing ({missing})")
        self._remove.setVisible(missing > 0)
        self.menu.addSeparator()
        self.menu.addActions([self._remove, self._clear])
        self._allow()

    def _allow(self) -> None:
        self.menu.menuAction().setEnabled(bool(self.frames.origins))

    def _entry(self, number: int, origin: Origin) -> QAction:
        """The entry of an origin, once made always the same: whoever lists the commands may hold it."""
        key, gone = key_of(origin), is_missing(origin)
        action = self._entries.get(key)
        if action is None:
            action = self._entries[key] = self._action(key, lambda: self._open(key))
            action.setObjectName(f"recent {key}")
            action.setProperty(WHY_NOT, "Its files are not there any more.")
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action.setText(f"{text} (missing)" if gone else text)
        action.setEnabled(not gone)
        return action

    def _action(self, hint: str, do: Callable[[], None]) -> QAction:
        action = QAction(self.desk.window)
        action.setToolTip(hint)
        action.setProperty(PASSING, True)
        action.triggered.connect(lambda: do())
        action.triggered.connect(lambda: self._allow())
        return action

    def _open(self, key: str) -> None:
        origin = next((origin for origin in self.frames.origins if key_of(origin) == key), None)
        if isinstance(origin, Path):
            self.desk.loader.open_run(origin)
        elif origin is not None:
            self.desk.documents.open_source(origin)
