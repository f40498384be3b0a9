"""The menu of what was opened last."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu

from gui import theme
from gui.desk import Desk, Part
from gui.frames.frame_source import FrameSource
from gui.inventory import PASSING, WHY_NOT
from gui.menus import insert_menu
from gui.recent.store import Origin, RecentFrames, is_missing, key_of, name_of

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
        self.menu.addSeparator()
        if missing:
            text = f"&Remove what is missing ({missing})"
            self._add(text, "Take the grey ones out of this list", self.frames.remove_missing)
        self._add("&Clear this list", "Forget what was opened; no file is touched", self.frames.clear)
        self._allow()

    def _allow(self) -> None:
        self.menu.menuAction().setEnabled(bool(self.frames.origins))

    def _entry(self, number: int, origin: Origin) -> QAction:
        gone = is_missing(origin)
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action = QAction(f"{text} (missing)" if gone else text, self.menu)
        action.setObjectName(f"recent {key_of(origin)}")
        action.setToolTip(key_of(origin))
        action.setProperty(PASSING, True)
        action.setProperty(WHY_NOT, "Its files are not there any more.")
        action.setEnabled(not gone)
        action.triggered.connect(lambda: self._open(origin))
        return action

    def _add(self, text: str, hint: str, do: Callable[[], None]) -> None:
        action = self.menu.addAction(text)
        action.setToolTip(hint)
        action.setProperty(PASSING, True)
        action.triggered.connect(lambda: do())
        action.triggered.connect(lambda: self._allow())

    def _open(self, origin: Origin) -> None:
        if isinstance(origin, Path):
            self.desk.loader.open_run(origin)
        else:
            self.desk.documents.open_source(origin)
