"""Which keys give which command: those that it comes with, and those that the user has chosen instead."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QObject, QSettings, Signal
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow

from gui.inventory import PASSING, Entry, entries_of, keys_text, plain

_KEY = "shortcuts"
_FIXED = {
    "Space": "pans the views",
    "Shift+Space": "pans the views",
    "Tab": "goes on to the next tool",
    "Shift+Tab": "goes back to the tool before",
    "Ctrl+Tab": "leads from the pictures to the panels",
    "Ctrl+Shift+Tab": "leads from the pictures to the panels",
    "Return": "finishes what is being drawn",
    "Enter": "finishes what is being drawn",
    "Backspace": "takes back the last point of what is being drawn",
}
"""Keys that mean something of their own all over the window."""

Keys = list[QKeySequence]


class Keymap(QObject):
    """The keys of all actions that can be found, now and later.

    Parameters
    ----------
    window : QMainWindow
        Whose actions they are.
    remembers : bool
        Whether what the user has chosen is known from session to session.

    Signals
    -------
    changed()
        Some action has other keys.
    """

    changed = Signal()

    def __init__(self, window: QMainWindow, remembers: bool) -> None:
        super().__init__(window)
        self._window = window
        self._remembers = remembers
        self._defaults: dict[str, Keys] = {}
        self._entries: dict[str, Entry] = {}
        self.update()

    @property
    def entries(self) -> list[Entry]:
        """All actions that are known."""
        return list(self._entries.values())

    def update(self) -> None:
        """Look for actions again: those that are new get the keys that the user has chosen for them before."""
        found = {entry.key: entry for entry in entries_of(self._window) if not entry.action.property(PASSING)}
        for key, entry in found.items():
            known = self._entries.get(key)
            if known is not None and known.action is entry.action:
                continue
            self._defaults[key] = entry.action.shortcuts()
            chosen = self._chosen(key)
            if chosen is not None:
                _give(entry.action, chosen)
        self._entries = found

    def default(self, key: str) -> Keys:
        """The keys that an action comes with."""
        return self._defaults[key]

    def is_changed(self, key: str) -> bool:
        """Whether an action has other keys than it comes with."""
        return self._entries[key].action.shortcuts() != self._defaults[key]

    def fixed(self, sequence: QKeySequence) -> str:
        """What a key does all over the window, so that no command can have it; "" for nothing."""
        text = sequence.toString(QKeySequence.SequenceFormat.PortableText)
        first = text.split(", ")[0]
        menus = {
            QKeySequence.mnemonic(action.text()).toString(): f"opens the menu {plain(action.text())}"
            for action in self._window.menuBar().actions()
        }
        held = {entry.held: f"is held for “{entry.text}”" for entry in self.entries}
        does = _FIXED.get(first) or menus.get(first) or held.get(first)
        return f"{first} {does}, and can be given to no command." if does else ""

    def clashes(self, key: str, sequence: QKeySequence) -> list[Entry]:
        """The other actions that have this sequence, or one that begins as it does or that it begins with."""
        return [
            entry
            for entry in self.entries
            if entry.key != key and any(_overlap(sequence, other) for other in entry.action.shortcuts())
        ]

    def set_keys(self, key: str, keys: Iterable[QKeySequence]) -> None:
        """Give an action other keys, at once."""
        self._set({key: list(keys)})

    def swap(self, key: str, sequence: QKeySequence, other: str) -> None:
        """Give an action the keys of another, and the other what the action has had."""
        self._set({key: [sequence], other: self._entries[key].action.shortcuts()})

    def take(self, key: str, sequence: QKeySequence) -> None:
        """Give an action a sequence, and take it from all others that have it."""
        changes: dict[str, Keys] = {}
        for entry in self.clashes(key, sequence):
            changes[entry.key] = [other for other in entry.action.shortcuts() if not _overlap(sequence, other)]
        self._set({**changes, key: [sequence]})

    def reset(self, key: str) -> None:
        """Give an action the keys that it comes with; those who have them now lose them."""
        changes: dict[str, Keys] = {key: self._defaults[key]}
        for sequence in self._defaults[key]:
            for entry in self.clashes(key, sequence):
                kept = changes.get(entry.key, entry.action.shortcuts())
                changes[entry.key] = [other for other in kept if not _overlap(sequence, other)]
        self._set(changes)

    def reset_all(self) -> None:
        """Give every action the keys that it comes with."""
        self._set(dict(self._defaults))

    def _set(self, changes: dict[str, Keys]) -> None:
        settings = QSettings()
        for key, keys in changes.items():
            if key in self._entries:
                _give(self._entries[key].action, keys)
            if not self._remembers:
                continue
            if keys == self._defaults[key]:
                settings.remove(f"{_KEY}/{_name(key)}")
            else:
                settings.setValue(f"{_KEY}/{_name(key)}", QKeySequence.listToString(keys))
        self.changed.emit()

    def _chosen(self, key: str) -> Keys | None:
        kept = QSettings().value(f"{_KEY}/{_name(key)}") if self._remembers else None
        if kept is None:
            return None
        # a list is how settings give text with commas in it
        text = "; ".join(kept) if isinstance(kept, list) else str(kept)
        return [sequence for sequence in QKeySequence.listFromString(text) if not sequence.isEmpty()]


def _give(action: QAction, keys: Keys) -> None:
    """Set an action's keys, and say them in its tooltip, if it has one of its own."""
    before, hint = keys_text(action.shortcuts()), action.toolTip()
    action.setShortcuts(keys)
    if hint.rstrip("…") == action.text().replace("&", "").rstrip("…"):
        return
    bare = hint.removesuffix(f" ({before})") if before else hint
    action.setToolTip(f"{bare} ({keys_text(keys)})" if keys else bare)


def _overlap(one: QKeySequence, other: QKeySequence) -> bool:
    no_match = QKeySequence.SequenceMatch.NoMatch
    return one.matches(other) is not no_match or other.matches(one) is not no_match


def _name(key: str) -> str:
    """A key as settings can hold it."""
    return key.replace("/", "|").replace("\\", "|")
