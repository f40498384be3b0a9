"""How a command of the window is declared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu


@dataclass(frozen=True)
class Command:
    """Declaration of an action.

    Attributes
    ----------
    name : str
    text : str
        As in a menu, with & before the letter that chooses it there.
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


# Everything that the window can be told to do: what stands in its menus, and what has a key or a button alone.


@dataclass(frozen=True, eq=False)
class Entry:
    """One action of the window.

    Attributes
    ----------
    key : str
        Tells it from others, also in another session: its name, or where it stands.
    text : str
        What it is called, without the mark of its letter.
    where : str
        Its menu ("View › Theme"); "" if it stands in none.
    action : QAction
    """

    key: str
    text: str
    where: str
    action: QAction

    @property
    def keys(self) -> str:
        """Its keys, as this system writes them, with the one that it is switched on by while that is held."""
        held = f"hold {self.held}" if self.held else ""
        return ", ".join(filter(None, (keys_text(self.action.shortcuts()), held)))

    @property
    def held(self) -> str:
        """The key that switches it on while it is held; "" for none."""
        return str(self.action.property(HELD) or "")

    @property
    def why_not(self) -> str:
        """Why it cannot be given now, as far as that is known; "" if it can be."""
        if self.action.isEnabled():
            return ""
        return str(self.action.property(WHY_NOT) or "Not now.")


WHY_NOT = "why_not"
"""The property in which an action says why it is disabled."""

HELD = "held"
"""The property of an action that a key switches on while it is held: which key."""

PASSING = "passing"
"""The property of an action that comes and goes: it is no use to give it keys."""


def keys_text(keys: list[QKeySequence]) -> str:
    """Keys as this system writes them."""
    return ", ".join(sequence.toString(QKeySequence.SequenceFormat.NativeText) for sequence in keys)


def plain(text: str) -> str:
    """Text of an action or a menu without the mark of its letter and without dots."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip("…")


def entries_of(window: QMainWindow) -> list[Entry]:
    """All actions of a window, each once: in the order of the menus, then those that stand in no menu."""
    found: dict[QAction, Entry] = {}
    for menu in _menus(window):
        menu.aboutToShow.emit()  # some are filled when they are looked at
        for action, where in _actions(menu, plain(menu.title())):
            found.setdefault(action, Entry(action.objectName() or f"{where}/{action.text()}", "", where, action))
    for action in window.actions():
        found.setdefault(action, Entry(action.objectName() or action.text(), "", "", action))
    return [
        Entry(entry.key, plain(action.text()), entry.where, action)
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
