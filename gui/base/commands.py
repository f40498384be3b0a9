"""Declaration of the window's commands, and a list of all its actions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu


@dataclass(frozen=True)
class Command:
    """The declaration of an action.

    Attributes
    ----------
    name : str
    text : str
        Menu text, with & before its mnemonic letter.
    icon, shortcut, hint : str
        "" for none.
    group : str
        Actions of one group are checkable, one at a time.
    checkable : bool
    """

    name: str
    text: str
    icon: str = ""
    shortcut: str = ""
    hint: str = ""
    group: str = ""
    checkable: bool = False


# All actions of the window: those in its menus, and those with only a key or a button.


@dataclass(frozen=True, eq=False)
class ActionEntry:
    """One action of the window.

    Attributes
    ----------
    key : str
        Unique identifier that stays the same in other sessions: its name, or its menu and text.
    text : str
        Its text without the mnemonic mark.
    where : str
        Its menu ("View › Theme"); "" if it is in no menu.
    action : QAction
    """

    key: str
    text: str
    where: str
    action: QAction

    @property
    def keys(self) -> str:
        """Its shortcuts in the system's notation, with the key that switches it on while held."""
        held = f"hold {self.held}" if self.held else ""
        return ", ".join(filter(None, (keys_text(self.action.shortcuts()), held)))

    @property
    def held(self) -> str:
        """The key that switches it on while held; "" for none."""
        return str(self.action.property(HOLD_KEY) or "")

    @property
    def why_not(self) -> str:
        """Why it is disabled; "" if it is enabled."""
        if self.action.isEnabled():
            return ""
        return str(self.action.property(WHY_NOT) or "Not available now.")


WHY_NOT = "why_not"
"""The property of an action that stores why it is disabled."""

HOLD_KEY = "held"
"""The property of an action that stores the key that switches it on while held."""

TEMPORARY = "transient"
"""The property of a temporary action, which cannot be given a shortcut."""


def keys_text(keys: list[QKeySequence]) -> str:
    """Return keys in the system's notation."""
    return ", ".join(sequence.toString(QKeySequence.SequenceFormat.NativeText) for sequence in keys)


def plain(text: str) -> str:
    """Return the text of an action or a menu without its mnemonic mark and dots."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip("…")


def action_entries(window: QMainWindow) -> list[ActionEntry]:
    """Return all actions of a window, each once: in the order of the menus, then those in no menu."""
    found: dict[QAction, ActionEntry] = {}
    for menu in _menus(window):
        menu.aboutToShow.emit()  # some are filled when they open
        for action, where in _actions(menu, plain(menu.title())):
            found.setdefault(action, ActionEntry(action.objectName() or f"{where}/{action.text()}", "", where, action))
    for action in window.actions():
        found.setdefault(action, ActionEntry(action.objectName() or action.text(), "", "", action))
    return [
        ActionEntry(entry.key, plain(action.text()), entry.where, action)
        for action, entry in found.items()
        if action.text() and action.isVisible()
    ]


def _menus(window: QMainWindow) -> list[QMenu]:
    menus = [action.menu() for action in window.menuBar().actions()]
    return [menu for menu in menus if isinstance(menu, QMenu)]


def _actions(menu: QMenu, where: str) -> Iterator[tuple[QAction, str]]:
    for action in menu.actions():
        below = action.menu()
        if isinstance(below, QMenu):
            below.aboutToShow.emit()
            yield from _actions(below, f"{where} › {plain(below.title())}")
        elif not action.isSeparator():
            yield action, where
