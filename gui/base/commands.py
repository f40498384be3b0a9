"""The window's commands: each is one record; menus, tool bar, palette, shortcuts and tooltips are made from these."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMainWindow, QMenu, QWidget
from shiboken6 import isValid

from . import theme
from .needs import NOTHING, Need, sentence

WHY_NOT = "why_not"
"""The property of an action that stores why it is disabled."""

HOLD_KEY = "held"
"""The property of an action that stores the key that switches it on while held."""

TEMPORARY = "transient"
"""The property of a temporary action, which cannot be given a shortcut."""


@dataclass(frozen=True, eq=False)
class Command:
    """One command of the window.

    Attributes
    ----------
    name : str
    text : str
        Menu text, with & before its mnemonic letter.
    hint, icon, keys : str
        "" for none.
    group : str
        Commands of one group are checkable, one at a time.
    checkable : bool
    held : str
        Letter of the key that switches it on while held; "" for none.
    handler : callable, optional
        Executes the command. If it is checkable, it is called with the state at each change, also by the program; of
        a group, it is called when the user chooses the command.
    needs : Need
        What must be there for it.
    why_off : callable, optional
        Given that this is there, returns why the command cannot be used now, as a sentence with what to do first; ""
        if it can.
    """

    name: str
    text: str
    hint: str = ""
    icon: str = ""
    keys: str = ""
    group: str = ""
    checkable: bool = False
    held: str = ""
    handler: Callable[..., object] | None = None
    needs: Need = NOTHING
    why_off: Callable[[], str] | None = None


class Actions:
    """The window's QActions by name: `actions["run"]`, made from the commands of its features.

    Parameters
    ----------
    window : QWidget
    missing : callable
        Returns what is missing of all that commands may need.
    """

    def __init__(self, window: QWidget, missing: Callable[[], Need]) -> None:
        self._window = window
        self._missing = missing
        self.commands: dict[str, Command] = {}
        """All commands by name, in the order in which they were added."""
        self._icons: dict[str, str] = {}
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}
        self._reasons: dict[str, str] = {}
        """Why the commands could not be used at the last refresh."""

    def __getitem__(self, name: str) -> QAction:
        return self._actions[name]

    def add(self, commands: Iterable[Command]) -> None:
        """Make the actions of a feature's commands."""
        for command in commands:
            action = QAction(command.text, self._window)
            action.setShortcut(QKeySequence(command.keys))
            keys = f" ({keys_text(action.shortcuts())})" if command.keys else ""
            action.setToolTip(f"{command.hint or command.text.replace('&', '')}{keys}")
            action.setCheckable(command.checkable or bool(command.group))
            if command.group:
                self._groups.setdefault(command.group, QActionGroup(self._window)).addAction(action)
            self._connect(action, command)
            self._window.addAction(action)
            self.commands[command.name] = command
            self.adopt(command.name, action, command.icon)

    def adopt(self, name: str, action: QAction, icon: str) -> None:
        """Add an action that was made elsewhere."""
        action.setObjectName(name)
        self._actions[name] = action
        self._icons[name] = icon
        self._draw_icons({name: icon})

    @staticmethod
    def _connect(action: QAction, command: Command) -> None:
        handler = command.handler
        if handler is None:
            return
        if command.checkable:
            action.toggled.connect(lambda on: handler(on))
        else:
            action.triggered.connect(lambda _=False: handler())

    def refresh(self) -> None:
        """Enable the commands that can be used now; store the reasons of the others."""
        missing = self._missing()
        for name, command in self.commands.items():
            if command.needs or command.why_off is not None:
                reason = sentence(command.needs & missing)
                if not reason and command.why_off is not None:
                    reason = command.why_off()
                if reason != self._reasons.get(name):
                    self._reasons[name] = reason
                    self[name].setEnabled(not reason)
                    self[name].setProperty(WHY_NOT, reason)

    def draw_icons(self) -> None:
        """Redraw the icons in the colours of the window's palette."""
        self._draw_icons(self._icons)

    def _draw_icons(self, icons: Mapping[str, str]) -> None:
        palette = self._window.palette()
        for name, icon in icons.items():
            if icon:
                self[name].setIcon(theme.icon(icon, palette))


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
    def gone(self) -> bool:
        """Whether its menu has been filled anew since, so that it does not exist any more."""
        return not isValid(self.action)

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
        if not entry.gone and action.text() and action.isVisible()
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
