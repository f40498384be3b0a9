"""The menu of the frames that were opened last."""

from __future__ import annotations

from pathlib import Path

from gui import theme
from gui.desk import Desk, Part
from gui.menus import insert_menu
from gui.recent.menu import RecentMenu
from gui.recent.store import Origin, RecentOrigins
from ilf.io.frame_source import FrameSource


class RecentPart(Part):
    """Notes what is opened, and opens it again, read in the same way."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.frames = RecentOrigins("frames", desk.panels.remembers)
        self._noted: set[str] = set()
        self.menu = RecentMenu("Open re&cent", self.frames, self._open, desk.window)
        desk.workspace.sessions_changed.connect(self._note)
        desk.loader.listed.connect(self.menu.note)

    def begin(self) -> None:
        """Stand in the menu beside what opens frames otherwise."""
        self.menu.setIcon(theme.icon("ph.clock-counter-clockwise", self.menu.palette()))
        insert_menu(self.desk.window.menuBar(), self.menu, self.desk.actions["open_run"])
        self.menu.fill()

    def _note(self) -> None:
        """Note what has been opened since the last time, but for what a project or a folder has brought."""
        workspace = self.desk.workspace
        open_now = {session.key: session for session in workspace.sessions}
        for key, session in open_now.items():
            entry = workspace.entries.of(session.id)
            brought = entry is not None and (entry.has_state or entry.of_folder)
            if key not in self._noted and not brought and isinstance(session.origin, FrameSource | Path):
                self.menu.note(session.origin)
        self._noted = set(open_now)

    def _open(self, origin: Origin) -> None:
        if isinstance(origin, Path):
            self.desk.loader.open_run(origin)
        else:
            self.desk.documents.open_source(origin)
