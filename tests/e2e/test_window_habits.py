"""The window's habits, driven by the keyboard alone; and names for all that can be used."""

from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QMenu, QPushButton, QToolButton

from gui.base.commands import why_not
from gui.features.blocks.feature import BlocksFeature
from gui.features.palette import listed
from gui.features.shortcuts import ShortcutsFeature
from gui.views.view_menus import SidesMenu
from tests.gui.naming import unnamed

from .conftest import activate, in_front, loaded

CTRL_SHIFT = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


def test_every_control_has_a_name(opened, qtbot):
    for toggle in opened.panels.toggles():
        toggle.setChecked(True)
    assert unnamed(opened) == []
    files = "open", "export", "load_blocks", "load_ground_truth"
    for name in (*files, "hold_out_test", "sweep", "save_preset", "shortcuts", "save_layout", "about"):
        opened.actions_[name].trigger()
        dialog = in_front(opened, QDialog)
        assert unnamed(dialog) == [], name
        assert dialog.windowTitle()
        dialog.close()


def test_a_command_is_found_given_and_has_another_key_without_the_mouse(opened, qtbot, frame_folder):
    activate(opened, qtbot)
    view = opened.views.cells["colour"].view
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_P, CTRL_SHIFT)
    palette = opened.feature(ShortcutsFeature).palette
    QTest.keyClicks(palette.field, "merge")
    assert palette.hint.text().startswith("Select two or more unlocked blocks first.")
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    assert palette.isVisible(), "it cannot be given"
    QTest.keyClick(palette.field, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    QTest.keyClicks(palette.field, "sel all")
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: list(opened.workspace.current.selected) == [1, 2])
    assert QApplication.focusWidget() is view

    keymap = opened.feature(ShortcutsFeature).keymap
    given = [(entry.key, keys) for entry in keymap.entries for keys in entry.action.shortcuts()]
    assert [key for key, keys in given if keymap.clashes(key, keys) or keymap.fixed(keys)] == [], "one key, one command"
    assert opened.actions_["delete_blocks"].shortcut().toString() == "Ctrl+Del", "no bare key deletes"
    opened.actions_["shortcuts"].trigger()
    dialog = in_front(opened, QDialog)
    dialog.filter.setText("fit frame")
    dialog.edit.setKeySequence(QKeySequence("Ctrl+Alt+F"))
    dialog.edit.editingFinished.emit()
    dialog.close()
    assert opened.actions_["fit"].toolTip() == "<b>Fit frame (Ctrl+Alt+F)</b><br>Show the whole frame"

    menu = opened.documents.recent
    menu.aboutToShow.emit()
    first, *_ = menu.actions()
    assert frame_folder.name in first.text()
    opened.documents.close_frame()
    loaded(opened, qtbot, first.trigger)
    assert opened.workspace.current.key == str(frame_folder)


def test_each_menu_opens_by_a_letter_and_no_letter_is_for_two_commands_of_a_menu(opened):
    bar, of_a_block = opened.menuBar(), opened.feature(BlocksFeature).menu_at(5, 5)
    assert all(QKeySequence.mnemonic(action.text()).toString() for action in bar.actions())
    for menu in (bar, of_a_block, *opened.findChildren(QMenu)):
        letters = [letter for one in menu.actions() if (letter := QKeySequence.mnemonic(one.text()).toString())]
        assert len(set(letters)) == len(letters), letters


def test_the_keys_of_a_sweep_of_one_parameter_are_each_for_one_thing(opened):
    opened.actions_["sweep"].trigger()
    dialog = in_front(opened, QDialog)
    labels = [label for label in dialog.findChildren(QLabel) if label.buddy() is not None and label.buddy().isEnabled()]
    named = [*labels, *dialog.findChildren(QPushButton)]
    keys = [key for control in named if (key := QKeySequence.mnemonic(control.text()).toString())]
    assert len(keys) > 8
    assert len(set(keys)) == len(keys)


def test_keys_of_a_command_that_cannot_be_used_say_why(opened, qtbot):
    activate(opened, qtbot)
    opened.workspace.select([])
    view, table = opened.views.cells["colour"].view, opened.feature(BlocksFeature).table
    for widget, code, modifiers, command in (
        (view, Qt.Key.Key_U, CTRL_SHIFT, "continue_plane"),
        (table, Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier, "merge_blocks"),
        (table, Qt.Key.Key_F6, Qt.KeyboardModifier.NoModifier, "pause"),
    ):
        widget.setFocus()
        opened.notes.clear()
        QTest.keyClick(widget, code, modifiers)
        why = why_not(opened.actions_[command])
        assert why
        assert opened.notes.message.partition(": ")[2] == why, command


def test_a_panel_is_found_by_what_it_shows(opened):
    palette = opened.feature(ShortcutsFeature).palette
    palette.toggle()
    QTest.keyClicks(palette.field, "curves")
    assert listed(palette.list)[0].text == "Convergence"
    QTest.keyClick(palette.field, Qt.Key.Key_Escape)
    assert not palette.isVisible()
    palette.toggle()
    opened.views.active.view.setFocus()
    assert not palette.isVisible(), "it goes when something else is turned to"
    palette.toggle()
    button = next(one for one in opened.findChildren(QToolButton) if one.defaultAction() is opened.actions_["live"])
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert not palette.isVisible(), "a button of a tool bar takes no focus"


def test_the_palette_survives_menus_that_are_filled_anew(opened, qtbot):
    palette = opened.feature(ShortcutsFeature).palette
    menu = next(menu for menu in opened.findChildren(SidesMenu))

    def at_side(text: str) -> int:
        return next(
            row for row, entry in enumerate(listed(palette.list)) if "Side A" in entry.where and entry.text == text
        )

    palette.toggle()
    QTest.keyClicks(palette.field, "depth in")
    palette.list.setCurrentIndex(palette.list.model().index(at_side("Depth in"), 0))
    menu.fill()
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    palette.list.viewport().grab()
    for code in (Qt.Key.Key_Down, Qt.Key.Key_Up):
        QTest.keyClick(palette.field, code)
    QTest.keyClick(palette.field, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: opened.views.data.chosen_sides[0] == "depth-in")
    palette.toggle()
    menu.fill()
    QTest.keyClicks(palette.field, "side")
    assert listed(palette.list)
    palette.leave()


def test_a_saved_picture_has_neither_crosshair_nor_focus(opened, qtbot, tmp_path):
    view, pictures = opened.views.active.view, []
    activate(opened, qtbot)
    for number, pointed in enumerate((False, True)):
        view.clearFocus()
        opened.views.navigation.point_at(None)
        if pointed:
            view.setFocus()
            opened.views.navigation.point_at((20, 10))
        assert opened.documents.save_picture(str(tmp_path / f"{number}.png"))
        pictures.append((tmp_path / f"{number}.png").read_bytes())
    assert pictures[0] == pictures[1]
    assert view.hasFocus()
