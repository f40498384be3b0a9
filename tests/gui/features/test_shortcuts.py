"""Keys can be changed in a list of all commands: at once, without two commands for one key, and for the next time."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMainWindow

from gui.base.commands import HINT, HOLD_KEY, describe, keys_text
from gui.features.palette import listed
from gui.features.shortcuts import Keymap, ShortcutsDialog


@pytest.fixture
def make_window(qtbot):
    def make() -> QMainWindow:
        window = QMainWindow()
        menu = window.menuBar().addMenu("&File")
        for name, keys in (("open", "Ctrl+O"), ("export", "Ctrl+E"), ("fit", ""), ("redo", "Ctrl+Y")):
            action = menu.addAction(f"&{name.capitalize()}")
            action.setObjectName(name)
            action.setShortcut(QKeySequence(keys))
            action.setProperty(HOLD_KEY, "B" if name == "export" else "")
            action.setProperty(HINT, f"Do {name}")
            describe(action)
        qtbot.addWidget(window)
        return window

    return make


def _keys(keymap: Keymap) -> dict[str, str]:
    return {entry.key: keys_text(entry.action.shortcuts()) for entry in keymap.entries}


def _tips(keymap: Keymap) -> list[str]:
    return [entry.action.toolTip() for entry in keymap.entries]


@pytest.fixture
def keymap(make_window):
    return Keymap(make_window())


@pytest.fixture
def dialog(keymap, shown):
    return shown(ShortcutsDialog(keymap))


def _press(dialog: ShortcutsDialog, name: str, key: Qt.Key, modifier: Qt.KeyboardModifier) -> None:
    dialog.choose(name)
    dialog.edit.setFocus()
    QTest.keyClick(dialog.edit, key, modifier)
    dialog.edit.editingFinished.emit()


def test_keys_that_are_pressed_hold_at_once_and_the_next_time(keymap, dialog, make_window):
    _press(dialog, "fit", Qt.Key.Key_J, Qt.KeyboardModifier.ControlModifier)
    assert _keys(keymap)["fit"] == "Ctrl+J"
    assert "<b>Fit (Ctrl+J)</b><br>Do fit" in _tips(keymap)
    dialog.choose("open")
    QTest.mouseClick(dialog.clear_button, Qt.MouseButton.LeftButton)
    assert _keys(keymap)["open"] == ""
    assert "<b>Open</b><br>Do open" in _tips(keymap)
    later = Keymap(make_window())
    assert _keys(later) == {"open": "", "export": "Ctrl+E", "fit": "Ctrl+J", "redo": "Ctrl+Y"}
    later.reset_all()
    assert _keys(Keymap(make_window()))["open"] == "Ctrl+O"


def test_keys_of_another_command_are_taken(keymap, dialog):
    _press(dialog, "open", Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    assert "“Export” has Ctrl+E" in dialog.message.text()
    assert _keys(keymap)["open"] == "Ctrl+O", "nothing is changed yet"
    QTest.mouseClick(dialog.take_button, Qt.MouseButton.LeftButton)
    assert _keys(keymap).items() >= {"open": "Ctrl+E", "export": ""}.items()
    dialog.choose("export")
    QTest.mouseClick(dialog.reset_button, Qt.MouseButton.LeftButton)
    assert _keys(keymap)["export"] == "Ctrl+E"
    assert _keys(keymap)["open"] != "Ctrl+E", "one key, one command"


def test_keys_are_offered_only_while_they_are_shown(keymap, dialog):
    _press(dialog, "open", Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    assert dialog.take_button.isVisible()
    QTest.keyPress(dialog.edit, Qt.Key.Key_Control)
    assert dialog.edit.keySequence().isEmpty()
    assert not dialog.take_button.isVisible()


@pytest.mark.parametrize(
    ("key", "modifier", "said"),
    [
        (Qt.Key.Key_Space, Qt.KeyboardModifier.NoModifier, "fixed meaning"),
        (Qt.Key.Key_B, Qt.KeyboardModifier.NoModifier, "is held down for “Export”"),
        (Qt.Key.Key_F, Qt.KeyboardModifier.AltModifier, "opens the menu File"),
    ],
)
def test_keys_with_a_meaning_of_their_own_are_refused(keymap, dialog, key, modifier, said):
    _press(dialog, "fit", key, modifier)
    assert said in dialog.message.text()
    assert _keys(keymap)["fit"] == ""


@pytest.mark.parametrize(
    ("key", "modifier"),
    [
        (Qt.Key.Key_Tab, Qt.KeyboardModifier.NoModifier),
        (Qt.Key.Key_Backtab, Qt.KeyboardModifier.ShiftModifier),
        (Qt.Key.Key_Escape, Qt.KeyboardModifier.NoModifier),
    ],
)
def test_keys_lead_out_of_the_field(keymap, dialog, key, modifier):
    dialog.activateWindow()
    _press(dialog, "open", key, modifier)
    assert not dialog.edit.hasFocus()
    assert _keys(keymap)["open"] == "Ctrl+O"
    assert dialog.isVisible() == (key != Qt.Key.Key_Escape)


def test_the_filter_finds_names_and_keys(dialog, qtbot):
    qtbot.keyClicks(dialog.filter, "exp")
    assert [entry.key for entry in listed(dialog.list)] == ["export"]
    dialog.filter.setText("ctrl+y")
    assert [entry.key for entry in listed(dialog.list)] == ["redo"]
    assert dialog.edit.keySequence() == QKeySequence("Ctrl+Y")
