"""The keys of the window's commands, as the user wants them, as a part of the window."""

from __future__ import annotations

from gui.desk import Desk, Part
from gui.shortcuts.dialog import ShortcutsDialog
from gui.shortcuts.keymap import Keymap


class ShortcutsPart(Part):
    """Gives the commands the keys that were chosen before, and lets others be chosen."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.keymap: Keymap | None = None
        desk.actions["shortcuts"].triggered.connect(self._ask)

    def begin(self) -> None:
        """Now all commands are there."""
        self.keymap = Keymap(self.desk.window, self.desk.panels.remembers)

    def _ask(self) -> None:
        if self.keymap is not None:
            ShortcutsDialog(self.keymap, self.desk.window).open()
