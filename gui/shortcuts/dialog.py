"""The list of all commands with their keys, in which the keys can be changed."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QHeaderView,
    QKeySequenceEdit,
    QLineEdit,
    QPushButton,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gui.inventory import Entry, keys_text
from gui.palette.matching import match
from gui.shortcuts.keymap import Keymap
from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel

_COMMAND, _MENU, _KEYS = range(3)
_HINT = "Choose a command, click the field and press its new keys. They hold at once."


class ShortcutsDialog(QDialog):
    """Filter, choose, press keys. Keys that another command has can be swapped with it or taken from it.

    Parameters
    ----------
    keymap : Keymap
        What is shown and changed.
    """

    def __init__(self, keymap: Keymap, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Keyboard shortcuts")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(620, 560)
        self._keymap = keymap
        self._items: dict[str, QTreeWidgetItem] = {}
        self._wanted = QKeySequence()
        self.filter = QLineEdit(placeholderText="Filter by name, menu or keys", clearButtonEnabled=True)
        self.filter.setAccessibleName("Filter")
        self.filter.setToolTip("Show only commands with these letters, in these menus or with these keys")
        self.list = QTreeWidget()
        self.list.setAccessibleName("Commands and their keys")
        self.list.setRootIsDecorated(False)
        self.list.setUniformRowHeights(True)
        self.list.setStyleSheet("QTreeView::item { padding: 3px 0; }")
        self.list.setAlternatingRowColors(True)
        self.list.setHeaderLabels(["Command", "Menu", "Keys"])
        self.list.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        header = self.list.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(_COMMAND, QHeaderView.ResizeMode.Stretch)
        for column in (_MENU, _KEYS):
            header.setSectionResizeMode(column, QHeaderView.ResizeMode.ResizeToContents)
        self.edit = QKeySequenceEdit()
        self.edit.setMaximumSequenceLength(1)
        self.edit.setToolTip("Press the keys that the chosen command shall have")
        label = PlainLabel("&Keys")
        label.setBuddy(self.edit)
        self.clear_button = QPushButton("&None", autoDefault=False)
        self.clear_button.setToolTip("Let the chosen command have no keys")
        self.reset_button = QPushButton("&Reset", autoDefault=False)
        self.reset_button.setToolTip("Give the chosen command the keys that it came with")
        self.message = Message(lines=2)
        self.swap_button = QPushButton("&Swap", autoDefault=False)
        self.swap_button.setToolTip("Give that command the keys that this one has had")
        self.take_button = QPushButton("&Take them", autoDefault=False)
        self.take_button.setToolTip("Leave that command without keys")
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.reset_all_button = QPushButton("Reset &all", autoDefault=False)
        self.reset_all_button.setToolTip("Give every command the keys that it came with")
        buttons.addButton(self.reset_all_button, QDialogButtonBox.ButtonRole.ResetRole)
        buttons.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        buttons.rejected.connect(self.reject)

        row, clash = QHBoxLayout(), QHBoxLayout()
        for widget in (label, self.edit, self.clear_button, self.reset_button):
            row.addWidget(widget, widget is self.edit)
        clash.addWidget(self.message, 1)
        for button in (self.swap_button, self.take_button):
            clash.addWidget(button, 0, Qt.AlignmentFlag.AlignTop)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(8)
        layout.addWidget(self.filter)
        layout.addWidget(self.list, 1)
        layout.addLayout(row)
        layout.addLayout(clash)
        layout.addWidget(buttons)

        self.filter.textChanged.connect(self._filter)
        self.list.currentItemChanged.connect(lambda *_: self._choose())
        self.list.itemActivated.connect(lambda *_: self.edit.setFocus())
        self.edit.editingFinished.connect(self._set)
        self.clear_button.clicked.connect(lambda: self._keymap.set_keys(self._key(), []))
        self.reset_button.clicked.connect(lambda: self._keymap.reset(self._key()))
        self.reset_all_button.clicked.connect(self._keymap.reset_all)
        self.swap_button.clicked.connect(self._swap)
        self.take_button.clicked.connect(lambda: self._keymap.take(self._key(), self._wanted))
        self._keymap.changed.connect(self._show)
        self._keymap.update()
        self._fill()

    def choose(self, key: str) -> None:
        """Choose the command of this key."""
        self.list.setCurrentItem(self._items[key])

    def shown(self) -> list[str]:
        """Keys of the commands that pass the filter."""
        return [key for key, item in self._items.items() if not item.isHidden()]

    def _fill(self) -> None:
        for entry in self._keymap.entries:
            item = QTreeWidgetItem([entry.text, entry.where, entry.keys])
            item.setData(_COMMAND, Qt.ItemDataRole.UserRole, entry.key)
            item.setToolTip(_COMMAND, entry.action.toolTip())
            self.list.addTopLevelItem(item)
            self._items[entry.key] = item
        self._show()
        self._choose_first()

    def _show(self) -> None:
        for entry in self._keymap.entries:
            item = self._items.get(entry.key)
            if item is None:
                continue
            item.setText(_KEYS, entry.keys)
            font = item.font(_KEYS)
            font.setBold(self._keymap.is_changed(entry.key))
            item.setFont(_KEYS, font)
        self._choose()

    def _filter(self, query: str) -> None:
        scores = {}
        for entry in self._keymap.entries:
            found = match(query, f"{entry.text} {entry.where}")
            fits = found is not None or query.lower() in entry.keys.lower()
            self._items[entry.key].setHidden(bool(query.strip()) and not fits)
            scores[entry.key] = 0.0 if found is None else found.score
        current = self.list.currentItem()
        if current is None or current.isHidden():
            self._choose_first(scores)

    def _choose_first(self, scores: Mapping[str, float] | None = None) -> None:
        """Choose the first command that is shown, or the one that fits best."""
        shown = self.shown()
        if shown:
            self.choose(max(shown, key=(scores or dict.fromkeys(shown, 0.0)).__getitem__))
        else:
            self.list.setCurrentIndex(QModelIndex())

    def _key(self) -> str:
        current = self.list.currentItem()
        return "" if current is None else str(current.data(_COMMAND, Qt.ItemDataRole.UserRole))

    def _entry(self) -> Entry | None:
        key = self._key()
        return next((entry for entry in self._keymap.entries if entry.key == key), None)

    def _choose(self) -> None:
        """Show the keys of the chosen command."""
        entry = self._entry()
        keys = entry.action.shortcuts() if entry is not None else []
        self._wanted = QKeySequence()
        self.edit.blockSignals(True)
        self.edit.setKeySequence(keys[0] if keys else QKeySequence())
        self.edit.blockSignals(False)
        self.edit.setEnabled(entry is not None)
        self.clear_button.setEnabled(bool(keys))
        changed = entry is not None and self._keymap.is_changed(entry.key)
        self.reset_button.setEnabled(changed)
        self.reset_all_button.setEnabled(any(self._keymap.is_changed(entry.key) for entry in self._keymap.entries))
        came = keys_text(self._keymap.default(entry.key)) or "none" if entry is not None and changed else ""
        self._say(f"It came with {came}." if came else _HINT)

    def _set(self) -> None:
        entry, wanted = self._entry(), self.edit.keySequence()
        if entry is None or wanted.isEmpty() or wanted == self._wanted or wanted in entry.action.shortcuts():
            return
        self._wanted = wanted
        fixed = self._keymap.fixed(wanted)
        others = self._keymap.clashes(entry.key, wanted)
        if fixed:
            self._say(fixed, "error")
        elif others:
            names = " and ".join(f"“{other.text}”" for other in others)
            verb = "has" if len(others) == 1 else "have"
            self._say(f"{names} {verb} {keys_text([wanted])}.", "warning", clash=True, swap=len(others) == 1)
        else:
            self._keymap.set_keys(entry.key, [wanted])

    def _swap(self) -> None:
        other = self._keymap.clashes(self._key(), self._wanted)[0]
        self._keymap.swap(self._key(), self._wanted, other.key)

    def _say(self, text: str, tone: str = "muted", clash: bool = False, swap: bool = False) -> None:
        self.message.say(text, tone)
        self.swap_button.setVisible(swap)
        self.take_button.setVisible(clash)
