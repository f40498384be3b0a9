"""The dialog that asks where missing files of frames are: its buttons, and what they ask for."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QWidget

from gui.features.project.missing import MissingFilesDialog
from ilf.data.frame import InputFile
from ilf.project.missing_files import MissingFile


@pytest.fixture
def dialog(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    yield MissingFilesDialog("house.ilf", parent)
    parent.close()


def lost(frame, path, changed=None):
    return MissingFile(frame, InputFile(path, "0" * 64), changed)


@pytest.fixture
def files(dialog, tmp_path):
    """A file that is gone, whose folder is there, and one that has changed."""
    gone = lost("a", str(tmp_path / "gone" / "rgb.png"))
    changed = lost("b", str(tmp_path / "depth.png"), tmp_path / "depth.png")
    dialog.show_files([("hall", gone), ("stairs", changed)])
    return gone, changed


def test_without_files_there_is_nothing_to_locate(dialog):
    dialog.show_files([])
    for button in (dialog.file_button, dialog.folder_button, dialog.new_button):
        assert not button.isEnabled()


def test_the_chosen_file_is_located(dialog, files, qtbot, tmp_path, monkeypatch):
    asked = []

    def choose(path):
        monkeypatch.setattr(
            QFileDialog, "getOpenFileName", lambda _, title, start: asked.append((title, start)) or path
        )

    choose((str(tmp_path / "new.png"), ""))
    with qtbot.waitSignal(dialog.file_located) as told:
        dialog.file_button.click()
    assert told.args == [files[0], tmp_path / "new.png"]
    assert asked == [("Locate rgb.png", str(tmp_path))], "from the nearest folder that is there"
    choose(("", ""))
    with qtbot.assertNotEmitted(dialog.file_located):
        dialog.file_button.click()


def test_a_folder_is_located_for_all(dialog, files, qtbot, tmp_path, monkeypatch):
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "moved"))
    with qtbot.waitSignal(dialog.folder_located) as told:
        dialog.folder_button.click()
    assert told.args == [Path(tmp_path / "moved")]
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: "")
    with qtbot.assertNotEmitted(dialog.folder_located):
        dialog.folder_button.click()


def test_only_a_changed_file_can_be_opened_as_a_new_frame(dialog, files, qtbot):
    assert not dialog.new_button.isEnabled()
    dialog.choose("b")
    with qtbot.waitSignal(dialog.new_frame_requested) as told:
        dialog.new_button.click()
    assert told.args == [files[1]]


def test_during_a_search_nothing_else_is_asked_for(dialog, files):
    dialog.show_search(0.2)
    assert not dialog.file_button.isEnabled()
    assert not dialog.folder_button.isEnabled()
    dialog.show_search(None)
    assert dialog.file_button.isEnabled()
