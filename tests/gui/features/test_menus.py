"""Menus, dialogs and keys of the main window."""

import pytest
from PySide6.QtGui import QAction, QImage
from PySide6.QtWidgets import QFileDialog

from gui.app.main_window import MainWindow
from ilf.data.presets import read_preset


@pytest.fixture
def window(qtbot):
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    yield window
    window.close()


def _entry(window: MainWindow, menu: str, text: str) -> QAction:
    """The entry of a menu by its text."""
    (bar_entry,) = (action for action in window.menuBar().findChildren(QAction) if action.text() == menu)
    (found,) = (action for action in bar_entry.menu().actions() if action.text() == text)
    return found


def test_the_menu_marks_the_depth_colours_however_they_were_chosen(window):
    entries = {name: _entry(window, "Depth colours", name.capitalize()) for name in ("turbo", "viridis", "grey")}
    for name in ("viridis", "turbo"):
        window.views.ranges.set_depth_map(name)
        assert [other for other, entry in entries.items() if entry.isChecked()] == [name]
    entries["grey"].trigger()
    assert window.views.data.depth_map == "grey"
    assert [other for other, entry in entries.items() if entry.isChecked()] == ["grey"]


def test_a_picture_of_the_views_and_a_preset_are_written_where_it_is_asked_for(window, tmp_path, monkeypatch):
    answers = ["", str(tmp_path / "window.png"), "", str(tmp_path / "mine")]
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (answers.pop(0), ""))
    monkeypatch.chdir(tmp_path)
    for write in (window.documents.ask_save_picture, window.actions_["export_preset"].trigger):
        before = {*tmp_path.iterdir(), tmp_path / "settings"}
        write()
        assert set(tmp_path.iterdir()) <= before, "cancelled"
        write()
    assert QImage(str(tmp_path / "window.png")).size() == window.views.size() * window.devicePixelRatio()
    assert read_preset(tmp_path / "mine.json").parameters == window.workspace.parameters.current
