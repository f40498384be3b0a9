"""The command palette finds what is meant, and is used by the keyboard alone."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QLineEdit, QMainWindow

from gui.base import theme
from gui.base.commands import WHY_NOT, action_entries
from gui.features.palette import CommandPalette, listed, match

_TEXTS = ["Run what changed", "Run all blocks", "Run chosen blocks", "Run blocks of this list"]
_TEXTS += ["Clean up", "Zoom to block", "Contours only"]


@pytest.mark.parametrize(
    ("query", "best"),
    [
        ("run all", "Run all blocks"),
        ("rcb", "Run chosen blocks"),
        ("blocks run ch", "Run chosen blocks"),
        ("CU", "Clean up"),
        ("zoom", "Zoom to block"),
        ("ctr", "Contours only"),
        ("what", "Run what changed"),
        ("run bl", "Run blocks of this list"),
    ],
)
def test_letters_find_what_they_begin_or_stand_in(query, best):
    found = {text: match(query, text) for text in _TEXTS}
    fitting = {text: score for text, score in found.items() if score is not None}
    assert max(fitting, key=lambda text: fitting[text]) == best


def test_letters_that_are_left_over_or_in_another_order_do_not_fit():
    assert match("runx", "Run all blocks") is None
    assert match("nur", "Run") is None
    assert match("fit", "Fit frame") > match("fit", "Fit frame to the window"), "the shorter text first"


@pytest.fixture
def window(shown):
    window = QMainWindow()
    window.given = []
    window.setCentralWidget(QLineEdit())
    file, view = window.menuBar().addMenu("&File"), window.menuBar().addMenu("&View")
    theme = view.addMenu("&Theme")
    for menu, text, name in ((file, "&Export…", "export"), (file, "&Quit", "quit"), (theme, "Dark", "")):
        action = menu.addAction(text)
        action.setObjectName(name)
        action.triggered.connect(lambda _=False, text=text: window.given.append(text))
    window.menuBar().actions()[0].menu().actions()[0].setShortcut("Ctrl+E")
    hidden = QAction("Larger brush", window)
    hidden.setEnabled(False)
    hidden.setProperty(WHY_NOT, "Open a frame first.")
    window.addAction(hidden)
    return shown(window, 800, 600)


def test_all_actions_are_found_with_their_menus_and_keys(window):
    found = {entry.text: entry for entry in action_entries(window)}
    assert list(found) == ["Export", "Quit", "Dark", "Larger brush"]
    assert found["Dark"].where == "View › Theme"
    assert (found["Export"].key, found["Export"].keys) == ("export", "Ctrl+E")
    assert found["Larger brush"].why_not == "Open a frame first."


def test_it_is_used_by_keys_alone_and_knows_what_was_given_last(window, qtbot):
    field = window.centralWidget()
    field.setFocus()
    palette = CommandPalette(window)
    palette.toggle()
    qtbot.keyClicks(palette.field, "dk")
    assert [entry.text for entry in listed(palette.list)] == ["Dark"]
    qtbot.keyClick(palette.field, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: window.given == ["Dark"])
    assert not palette.isVisible()
    assert QApplication.focusWidget() is field
    again = CommandPalette(window)
    again.toggle()
    assert [entry.text for entry in listed(again.list)] == ["Dark", "Export", "Quit", "Larger brush"]
    qtbot.keyClick(again.field, Qt.Key.Key_Down)
    qtbot.keyClick(again.field, Qt.Key.Key_Down)
    qtbot.keyClick(again.field, Qt.Key.Key_Enter)
    qtbot.waitUntil(lambda: window.given == ["Dark", "&Quit"])


@pytest.mark.usefixtures("any_theme")
def test_it_takes_a_theme_that_is_chosen_while_it_is_closed(window, qapp):
    palette = CommandPalette(window)
    for name in ("light", "dark"):
        theme.apply_theme(qapp, name)
        palette.toggle()
        shown = palette.grab().toImage().pixelColor(palette.width() // 2, palette.height() - 4)
        assert shown == qapp.palette().window().color()
        palette.leave()


def test_whole_words_of_a_menu_come_before_letters_scattered_over_a_text(window, qtbot):
    window.addAction(QAction("Tighten some", window))
    palette = CommandPalette(window)
    palette.toggle()
    qtbot.keyClicks(palette.field, "theme")
    assert [entry.text for entry in listed(palette.list)] == ["Dark", "Tighten some"]
