"""The window's commands, each declared at its handler: menus, tool bar, palette, shortcuts and tooltips follow."""

from __future__ import annotations

import html
import inspect
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar

from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QAction, QActionGroup, QIcon, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QMainWindow,
    QMenu,
    QMenuBar,
    QToolBar,
    QToolButton,
    QWidget,
)
from shiboken6 import isValid

from . import theme
from .needs import NOTHING, Need, sentence

WHY_NOT = "why_not"
"""The property of an action of no command that stores why it is disabled."""

HOLD_KEY = "held"
"""The property of an action that stores the key that switches it on while held."""

HINT = "hint"
"""The property of an action that stores what it does, as a sentence without a stop."""

TEMPORARY = "transient"
"""The property of a temporary action, which cannot be given a shortcut."""

_COMMAND = "_command"
"""The attribute of a method that is the command it is the handler of."""

Handler = TypeVar("Handler", bound=Callable[..., object])


@dataclass(frozen=True, eq=False)
class Command:
    """One command of the window; as a decorator, it declares a method as its handler.

    Attributes
    ----------
    name : str
    text : str
        Menu text, with & before its mnemonic letter.
    hint, icon, keys : str
        "" for none. The hint of a declared method is the first paragraph of its docstring.
    group : str
        Commands of one group are checkable, one at a time.
    checkable : bool
    on : bool
        Whether it is on at first.
    remembered : str
        Key of the setting that stores between program starts whether it is on; "" for none.
    held : str
        Letter of the key that switches it on while held; "" for none.
    handler : callable, optional
        Executes the command. If it is checkable, it is called with the state at each change, also by the program; of
        a group, it is called when the user chooses the command.
    needs : Need
        What must be there for it.
    why_off : callable, optional
        Given that this is there, returns why the command cannot be used now, as a sentence with what to do first; ""
        if it can. It is asked when somebody looks: at a button, as a menu opens, before its key is used. Declared
        beside a method, it is given the object of the method.
    """

    name: str
    text: str
    hint: str = ""
    icon: str = ""
    keys: str = ""
    group: str = ""
    checkable: bool = False
    on: bool = False
    remembered: str = ""
    held: str = ""
    handler: Callable[..., object] | None = None
    needs: Need = NOTHING
    why_off: Callable[..., str] | None = None

    def __call__(self, handler: Handler) -> Handler:
        """Declare a method as the handler."""
        setattr(handler, _COMMAND, replace(self, hint=first_paragraph(handler), handler=handler))
        return handler


command = Command


def first_paragraph(described: object) -> str:
    """Return the first paragraph of a docstring, on one line without the full stop."""
    return " ".join((inspect.getdoc(described) or "").partition("\n\n")[0].split()).removesuffix(".")


def commands_of(kind: type, owner: Callable[[], object]) -> Iterator[Command]:
    """Yield the commands of a class, in the order of their definition: those whose handlers are its methods, and those
    of its attribute `more_commands`. `owner` returns the object with the methods; it is called when one is used."""
    for base in reversed(kind.__mro__):
        declared = [getattr(member, _COMMAND, None) for member in vars(base).values()]
        for one in (*filter(None, declared), *vars(base).get("more_commands", ())):
            yield replace(one, handler=_bound(one.handler, owner), why_off=_bound(one.why_off, owner))


def _bound(method: Callable[..., Any] | None, owner: Callable[[], object]) -> Callable[..., Any] | None:
    return None if method is None else lambda *given: method(owner(), *given)


class CommandAction(QAction):
    """The action of a command.

    Its tooltip is made when the pointer comes to it, with the keys it has then, and what is missing if it is off.

    Parameters
    ----------
    command : Command
    missing : callable
        Returns what is missing of all that commands may need.
    """

    def __init__(self, command: Command, missing: Callable[[], Need], window: QWidget) -> None:
        super().__init__(command.text, window)
        self._command = command
        self._missing = missing
        self.setProperty(HINT, command.hint)
        self.setProperty(HOLD_KEY, command.held)
        self.setObjectName(command.name)
        self.setShortcut(QKeySequence(command.keys))
        self.setCheckable(command.checkable or bool(command.group))
        self.setChecked(command.on)
        self.hovered.connect(self.explain)
        self.explain()

    def why_not(self) -> str:
        """Return why the command cannot be used now, as a sentence with what to do first; "" if it can."""
        command = self._command
        return sentence(command.needs & self._missing()) or (command.why_off() if command.why_off is not None else "")

    def enable(self, missing: Need, asked: bool = False) -> None:
        """Enable the action, given what is missing; what else keeps it off counts only if it is asked for, or a button
        is seen."""
        needs, why_off = self._command.needs, self._command.why_off
        self.setEnabled(not (needs & missing or (why_off is not None and (asked or self._is_seen()) and why_off())))

    def _is_seen(self) -> bool:
        return any(isinstance(button, QToolButton) and button.isVisible() for button in self.associatedObjects())

    def isEnabled(self) -> bool:
        """Whether the command can be used now, though the last change may not be told yet."""
        self.enable(self._missing(), asked=True)
        return super().isEnabled()

    def trigger(self) -> None:
        """Use the command if it can be used now."""
        if self.isEnabled():
            super().trigger()

    def explain(self) -> None:
        """Make the tooltip."""
        self.setToolTip(_tooltip(self, "" if super().isEnabled() else self.why_not()))


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
        self.held: dict[int, QAction] = {}
        """Key -> the action that it switches on while held."""
        self._actions: dict[str, QAction] = {}
        self._groups: dict[str, QActionGroup] = {}

    def __getitem__(self, name: str) -> QAction:
        if name not in self._actions:
            raise LookupError(f"No feature declares a command {name!r}, which a menu, a bar or a panel names.")
        return self._actions[name]

    def is_on(self, name: str) -> bool:
        """Whether a checkable command is on; False while there is no such command yet."""
        return name in self._actions and self._actions[name].isChecked()

    def add(self, commands: Iterable[Command]) -> None:
        """Make the actions of a feature's commands."""
        added = list(commands)
        for command in added:
            action = CommandAction(command, self._missing, self._window)
            if command.group:
                self._groups.setdefault(command.group, QActionGroup(self._window)).addAction(action)
            self._connect(action, command)
            if command.held:
                self.held[Qt.Key[f"Key_{command.held}"]] = action
            self._window.addAction(action)
            self.commands[command.name] = command
            self.adopt(command.name, action, command.icon)
        for command in added:
            if command.remembered:
                self._remember(self[command.name], command)

    @staticmethod
    def _remember(action: QAction, command: Command) -> None:
        """Restore whether a command is on, and store each change."""
        settings = QSettings()
        action.setChecked(settings.value(command.remembered, command.on, bool) is True)
        action.toggled.connect(partial(settings.setValue, command.remembered))

    def adopt(self, name: str, action: QAction, icon: str = "") -> None:
        """Add an action that was made elsewhere, as that of a menu."""
        action.setObjectName(name)
        self._actions[name] = action
        if icon:
            action.setIcon(theme.icon(icon))

    def menu(self, title: str, parent: QWidget, names: str = "") -> QMenu:
        """Make a menu of actions, which are on or off as it opens; `names` as of `fill`."""
        menu = QMenu(title, parent)
        menu.setToolTipsVisible(True)
        menu.aboutToShow.connect(partial(_ask, menu))
        self.fill(menu, names)
        return menu

    def fill(self, place: QMenu | QToolBar, names: str) -> None:
        """Add actions by their names to a menu or a bar, with a separator for each "|"."""
        for name in names.split():
            if name == "|":
                place.addSeparator()
            else:
                place.addAction(self[name])

    def _connect(self, action: CommandAction, command: Command) -> None:
        handler = command.handler
        if handler is None:
            return
        if command.checkable:
            action.toggled.connect(lambda on: handler(on))
            return

        def use() -> None:
            take_typed()
            if action.why_not():  # something has changed since commands were enabled
                self.refresh()
            else:
                handler()

        action.triggered.connect(lambda _=False: use())

    def refresh(self) -> None:
        """Enable the commands that can be used now."""
        missing = self._missing()
        for action in self._actions.values():
            if isinstance(action, CommandAction):
                action.enable(missing)


def take_typed() -> None:
    """Take over what is being typed into a number field or a row of a list, as if the focus had left it."""
    field = QApplication.focusWidget()
    viewport = None if field is None else field.parentWidget()
    holder = None if viewport is None else viewport.parentWidget()
    if isinstance(field, QAbstractSpinBox):
        field.interpretText()
    elif field is not None and isinstance(holder, QAbstractItemView):
        holder.itemDelegateForIndex(holder.currentIndex()).commitData.emit(field)


def _ask(menu: QMenu) -> None:
    """Enable the actions of a menu that can be used now."""
    for action in menu.actions():
        action.isEnabled()


def why_not(action: QAction) -> str:
    """Return why an action is disabled, as a sentence; "" if it is enabled."""
    if action.isEnabled():
        return ""
    told = action.why_not() if isinstance(action, CommandAction) else action.property(WHY_NOT)
    return str(told or "Not available now.")


def hint_of(action: QAction) -> str:
    """Return what an action does, as a sentence without its name and keys; "" if its text says it."""
    return str(action.property(HINT) or "")


def describe(action: QAction) -> None:
    """Make the tooltip of an action anew: its name and keys in bold, and what it does."""
    action.setToolTip(_tooltip(action))


def _tooltip(action: QAction, why: str = "") -> str:
    name, keys = plain(action.text()), all_keys(action)
    title = f"<b>{html.escape(f'{name} ({keys})' if keys else name)}</b>"
    return "<br>".join(filter(None, (title, html.escape(hint_of(action)), html.escape(why))))


# All actions of the window: those in its menus, and those with only a key or a button.


@dataclass(frozen=True, eq=False)
class ActionEntry:
    """One action of the window, as it was when the actions were listed: its menu may be filled anew since.

    Attributes
    ----------
    key : str
        Unique identifier that stays the same in other sessions: its name, or its menu and text.
    text : str
        Its text without the mnemonic mark.
    where : str
        Its menu ("View › Theme"); "" if it is in no menu.
    action : QAction
    hint : str
        What it does.
    icon : QIcon
    is_on : bool
        Whether it is checked.
    """

    key: str
    text: str
    where: str
    action: QAction
    hint: str
    icon: QIcon
    is_on: bool

    @cached_property
    def why_not(self) -> str:
        """Why it is disabled, as it was when this was first asked; "" if it is enabled."""
        return "" if self.gone else why_not(self.action)

    @property
    def gone(self) -> bool:
        """Whether its menu has been filled anew since, so that it does not exist any more."""
        return not isValid(self.action)

    @property
    def held(self) -> str:
        """The key that switches it on while held; "" for none."""
        return "" if self.gone else str(self.action.property(HOLD_KEY) or "")

    @property
    def keys(self) -> str:
        """Its shortcuts in the system's notation, with the key that switches it on while held."""
        return "" if self.gone else all_keys(self.action)


def keys_text(keys: list[QKeySequence]) -> str:
    """Return keys in the system's notation."""
    return ", ".join(sequence.toString(QKeySequence.SequenceFormat.NativeText) for sequence in keys)


def all_keys(action: QAction) -> str:
    """Return the keys of an action, with the one that switches it on while held."""
    held = action.property(HOLD_KEY)
    return ", ".join(filter(None, (keys_text(action.shortcuts()), f"hold {held}" if held else "")))


def plain(text: str) -> str:
    """Return the text of an action or a menu without its mnemonic mark and dots."""
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&").rstrip("…")


def action_entries(window: QMainWindow) -> list[ActionEntry]:
    """Return all actions of a window, each once: in the order of the menus, then those in no menu."""
    found: dict[QAction, str] = {}
    for action, where in _actions(window.menuBar(), ""):
        found.setdefault(action, where)
    for action in window.actions():
        found.setdefault(action, "")
    return [
        _entry(action, where)
        for action, where in found.items()
        if isValid(action) and action.text() and action.isVisible()
    ]


def _entry(action: QAction, where: str) -> ActionEntry:
    key = action.objectName() or (f"{where}/{action.text()}" if where else action.text())
    return ActionEntry(key, plain(action.text()), where, action, hint_of(action), action.icon(), action.isChecked())


def _actions(holder: QMenuBar | QMenu, where: str) -> Iterator[tuple[QAction, str]]:
    """Yield the actions below a menu or the menu bar, with the titles of their menus."""
    for action in holder.actions():
        below = action.menu()
        if isinstance(below, QMenu):
            below.aboutToShow.emit()  # some are filled when they open
            title = plain(below.title())
            yield from _actions(below, f"{where} › {title}" if where else title)
        elif not action.isSeparator():
            yield action, where
