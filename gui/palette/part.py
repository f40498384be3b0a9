"""The command palette as a part of the window."""

from __future__ import annotations

from gui.desk import Desk, Part
from gui.palette.palette import CommandPalette


class PalettePart(Part):
    """Brings the palette when it is asked for."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.palette = CommandPalette(desk.window, desk.panels.remembers)
        desk.actions["palette"].triggered.connect(self.palette.toggle)
