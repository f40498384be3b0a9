"""All commands of the window: found in the palette, and used by their keys, which the user can change."""

from __future__ import annotations

from functools import cached_property

from PySide6.QtCore import QEvent, QObject, QSettings, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QKeySequenceEdit,
    QLineEdit,
    QMainWindow,
    QPushButton,
    QWidget,
)

from ..base.commands import (
    TEMPORARY,
    ActionEntry,
    action_entries,
    command,
    describe,
    keys_text,
    plain,
    why_not,
)
from ..widgets.basics import Message, give_size, label_of, lay_out, open_once, stack
from .context import Context, Feature
from .palette import CommandPalette, command_list, current_entry, list_commands, listed
from .tools import ToolsFeature

# Keys of the commands: the defaults, and those set by the user.

_KEY = "shortcuts"
_FIXED = {
    *("Space", "Shift+Space", "Ctrl+Space", "Tab", "Shift+Tab", "Return", "Enter", "Alt+Return", "Backspace"),
    *(f"{held}{arrow}" for arrow in ("Left", "Right", "Up", "Down") for held in ("", "Shift+", "Ctrl+", "Alt+")),
}
"""Keys with a fixed meaning in the whole window."""

_DEFAULT = "default_keys"
"""The property of an action that stores its keys before the user's."""

Keys = list[QKeySequence]


class Keymap(QObject):
    """Keyboard shortcuts of all actions of a window, including actions added later.

    Parameters
    ----------
    window : QMainWindow
        The window with the actions.

    Signals
    -------
    changed()
        The keys of an action have changed.
    """

    changed = Signal()

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._entries: dict[str, ActionEntry] = {}
        self.update()

    @property
    def entries(self) -> list[ActionEntry]:
        """All known actions, without those whose menu has been filled anew since."""
        return [entry for entry in self._entries.values() if not entry.gone]

    def update(self) -> None:
        """Find the actions again, and apply the user's stored keys to new ones."""
        found = {entry.key: entry for entry in action_entries(self._window) if not entry.action.property(TEMPORARY)}
        for key, entry in found.items():
            if entry.action.property(_DEFAULT) is not None:
                continue
            entry.action.setProperty(_DEFAULT, entry.action.shortcuts())
            stored = QSettings().value(f"{_KEY}/{_name(key)}")
            if stored is not None:
                # QSettings returns text with commas as a list
                text = "; ".join(stored) if isinstance(stored, list) else str(stored)
                _assign(entry.action, [keys for keys in QKeySequence.listFromString(text) if not keys.isEmpty()])
        self._entries = found

    def fixed(self, sequence: QKeySequence) -> str:
        """Return the fixed meaning of a key, which no command can have then; "" for none."""
        text = sequence.toString(QKeySequence.SequenceFormat.PortableText)
        first = text.split(", ")[0]
        menus = {
            QKeySequence.mnemonic(action.text()).toString(): f"opens the menu {plain(action.text())}"
            for action in self._window.menuBar().actions()
        }
        held = {entry.held: f"is held down for “{entry.text}”" for entry in self.entries}
        does = "has a fixed meaning" if first in _FIXED else menus.get(first) or held.get(first)
        return f"{first} {does} and cannot be assigned to a command." if does else ""

    def clashes(self, key: str, sequence: QKeySequence) -> list[ActionEntry]:
        """Return the other actions that have these keys."""
        return [entry for entry in self.entries if entry.key != key and sequence in entry.action.shortcuts()]

    def assign(self, key: str, keys: Keys) -> None:
        """Assign keys to an action, and remove them from all others."""
        others = {other.key: other.action.shortcuts() for sequence in keys for other in self.clashes(key, sequence)}
        self._set({key: keys, **{other: [one for one in kept if one not in keys] for other, kept in others.items()}})

    def reset_all(self) -> None:
        """Restore the default keys of all actions."""
        self._set({entry.key: default_keys(entry.action) for entry in self.entries})

    def _set(self, changes: dict[str, Keys]) -> None:
        settings = QSettings()
        for key, keys in changes.items():
            action = self._entries[key].action
            _assign(action, keys)
            if not is_changed(action):
                settings.remove(f"{_KEY}/{_name(key)}")
            else:
                settings.setValue(f"{_KEY}/{_name(key)}", QKeySequence.listToString(keys))
        self.changed.emit()


def default_keys(action: QAction) -> Keys:
    """Return the keys that an action has if the user chooses no others."""
    return list(action.property(_DEFAULT))


def is_changed(action: QAction) -> bool:
    """Whether an action has other keys than its default ones."""
    return action.shortcuts() != default_keys(action)


def _assign(action: QAction, keys: Keys) -> None:
    """Set an action's keys, also in its tooltip."""
    action.setShortcuts(keys)
    describe(action)


def _name(key: str) -> str:
    """Return a key in a form that settings can store."""
    return key.replace("/", "|").replace("\\", "|")


# The dialog with all commands and their keys, where the keys can be changed.

_HINT = "Select a command, click the field and press the new keys. They apply at once."


class ShortcutsDialog(QDialog):
    """Dialog to change keyboard shortcuts. Keys of another command can be taken from it.

    Parameters
    ----------
    keymap : Keymap
        The shortcuts to show and change.
    """

    def __init__(self, keymap: Keymap, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Keyboard shortcuts")
        give_size(self, 620, 560)
        self._keymap = keymap
        self.filter = QLineEdit(placeholderText="Filter by name, menu or keys", clearButtonEnabled=True)
        self.filter.setAccessibleName("Filter")
        self.filter.setToolTip("Show only commands that match by name, menu or keys")
        self.list = command_list()
        self.list.setAlternatingRowColors(True)
        self.edit = _KeysField()
        self.edit.setMaximumSequenceLength(1)
        self.edit.setToolTip("Press the new keys of the selected command")
        self.clear_button = QPushButton("&None", autoDefault=False)
        self.clear_button.setToolTip("Remove the shortcut")
        self.reset_button = QPushButton("&Reset", autoDefault=False)
        self.reset_button.setToolTip("Restore the default keys of the selected command")
        self.message = Message(lines=2)
        self.take_button = QPushButton("&Reassign", autoDefault=False)
        self.take_button.setToolTip("Assign the keys to this command, and remove them from the other one")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.reset_all_button = QPushButton("Reset &all", autoDefault=False)
        self.reset_all_button.setToolTip("Restore the default keys of all commands")
        buttons.addButton(self.reset_all_button, QDialogButtonBox.ButtonRole.ResetRole)
        buttons.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        buttons.rejected.connect(self.reject)

        keys = label_of("&Keys", self.edit), self.edit, self.clear_button, self.reset_button
        clash = lay_out(QHBoxLayout(), self.message, self.take_button, stretched=self.message)
        row = lay_out(QHBoxLayout(), *keys, stretched=self.edit)
        stack(self, self.filter, self.list, row, clash, buttons, stretched=self.list, spacing=8)

        self.filter.textChanged.connect(self._list)
        self.list.currentItemChanged.connect(lambda *_: self._choose())
        self.list.itemActivated.connect(lambda *_: self.edit.setFocus())
        self.edit.keySequenceChanged.connect(lambda _: self._say(_HINT))  # what was offered is of the former keys
        self.edit.editingFinished.connect(self._set)
        self.clear_button.clicked.connect(lambda: self._assign([]))
        self.reset_button.clicked.connect(lambda: self._assign(None))
        self.reset_all_button.clicked.connect(self._keymap.reset_all)
        self.take_button.clicked.connect(lambda: self._assign([self.edit.keySequence()]))
        self._keymap.changed.connect(self._list)
        self._keymap.update()
        self._list()

    def choose(self, key: str) -> None:
        """Select the command with this key."""
        row = [entry.key for entry in listed(self.list)].index(key)
        self.list.setCurrentIndex(self.list.model().index(row, 0))

    def _list(self) -> None:
        """List the commands that match the filter, with the same one selected if it is one of them."""
        present = current_entry(self.list)
        with QSignalBlocker(self.list):
            for item, entry in list_commands(self.list, self._keymap.entries, self.filter.text()):
                item.setToolTip(0, entry.hint)
                font = item.font(2)
                font.setBold(is_changed(entry.action))
                item.setFont(2, font)
                if present is not None and entry.key == present.key:
                    self.list.setCurrentItem(item)
        self._choose()

    def _assign(self, keys: Keys | None) -> None:
        """Assign keys to the selected command; None for its default ones."""
        if (entry := current_entry(self.list)) is not None:
            self._keymap.assign(entry.key, default_keys(entry.action) if keys is None else keys)

    def _choose(self) -> None:
        """Show the keys of the selected command."""
        entry = current_entry(self.list)
        keys = entry.action.shortcuts() if entry is not None else []
        with QSignalBlocker(self.edit):
            self.edit.setKeySequence(keys[0] if keys else QKeySequence())
        self.edit.setEnabled(entry is not None)
        self.clear_button.setEnabled(bool(keys))
        changed = entry is not None and is_changed(entry.action)
        self.reset_button.setEnabled(changed)
        self.reset_all_button.setEnabled(any(is_changed(one.action) for one in self._keymap.entries))
        came = keys_text(default_keys(entry.action)) or "none" if entry is not None and changed else ""
        self._say(f"Default: {came}." if came else _HINT)

    def _set(self) -> None:
        entry, wanted = current_entry(self.list), self.edit.keySequence()
        if entry is None or wanted.isEmpty() or wanted in entry.action.shortcuts():
            return
        fixed = self._keymap.fixed(wanted)
        others = self._keymap.clashes(entry.key, wanted)
        if fixed:
            self._say(fixed, "error")
        elif others:
            names = " and ".join(f"“{other.text}”" for other in others)
            verb = "has" if len(others) == 1 else "have"
            self._say(f"{names} {verb} {keys_text([wanted])}.", "warning", clash=True)
        else:
            self._keymap.assign(entry.key, [wanted])

    def _say(self, text: str, tone: str = "muted", clash: bool = False) -> None:
        self.message.show_message(text, tone)
        self.take_button.setVisible(clash)


class _KeysField(QKeySequenceEdit):
    """Takes the keys that are pressed, but leaves those that lead out of it."""

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Leave Escape to the dialog, and Shift+Tab to the focus."""
        if event.key() == Qt.Key.Key_Backtab:
            self.focusPreviousChild()
        elif event.key() == Qt.Key.Key_Escape:
            event.ignore()
        else:
            super().keyPressEvent(event)


class ShortcutsFeature(Feature):
    """Applies the user's keyboard shortcuts, opens the dialog to change them, and the command palette."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        context.feature(ToolsFeature).keys.on_unused = self._tell_off

    def apply_keys(self) -> None:
        """Apply the user's keys, if there are any, to all commands, which are in the menus by now."""
        if _KEY in QSettings().childGroups():
            _ = self.keymap

    @cached_property
    def keymap(self) -> Keymap:
        """The keys of all commands, made when the first of the user's is stored or may be chosen."""
        return Keymap(self.context.window)

    def _tell_off(self, event: QKeyEvent) -> bool:
        """Say why a command cannot be used if its keys are pressed."""
        if event.type() == QEvent.Type.ShortcutOverride:
            self.context.refresh.now()
            self._commands_off(event)  # the key finds the commands as they are after the last change
        elif event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat():
            for action in self._commands_off(event):
                self.notes.show_message(f"{plain(action.text())}: {why_not(action)}")
                return True
        return False

    def _commands_off(self, event: QKeyEvent) -> list[QAction]:
        """Return the commands of a key that cannot be used now."""
        pressed = QKeySequence(event.keyCombination())
        actions = self.context.window.actions()
        return [action for action in actions if pressed in action.shortcuts() and not action.isEnabled()]

    @command("shortcuts", "&Keyboard shortcuts…", icon="ph.keyboard", keys="F1")
    def _ask(self) -> None:
        """Show the keyboard shortcuts and change them."""
        open_once(ShortcutsDialog(self.keymap, self.context.window))

    @cached_property
    def palette(self) -> CommandPalette:
        """The command palette, made when it is first used."""
        return CommandPalette(self.context.window)

    @command("palette", "Command &palette…", icon="ph.magnifying-glass", keys="Ctrl+Shift+P")
    def _toggle_palette(self) -> None:
        """Find a command by part of its name."""
        self.palette.toggle()
