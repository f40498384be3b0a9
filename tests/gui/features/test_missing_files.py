"""The dialog that asks where missing files of frames are: its buttons, and what they ask for."""

from threading import Event
from unittest.mock import Mock

import pytest
from PySide6.QtWidgets import QFileDialog, QWidget

from gui.features.project.missing import Missing, MissingFilesDialog
from gui.work.latest_request import LatestRequest
from ilf.data.frame import InputFile
from ilf.project.missing_files import MissingFile


@pytest.fixture
def asked():
    """What the dialog has asked for; its search waits for an event."""
    return Mock(spec=Missing, search=LatestRequest(lambda event: event.wait(10)))


@pytest.fixture
def dialog(qtbot, asked):
    parent = QWidget()
    qtbot.addWidget(parent)
    yield MissingFilesDialog("house.ilf", asked, parent)
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


def test_the_chosen_file_is_located(dialog, files, asked, tmp_path, monkeypatch):
    seen = []

    def choose(path):
        monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda _, title, start: seen.append((title, start)) or path)
        dialog.file_button.click()

    choose(("", ""))
    asked.look.assert_not_called()
    choose((str(tmp_path / "new.png"), ""))
    asked.look.assert_called_once_with(tmp_path / "new.png", files[0])
    assert seen[0] == ("Locate rgb.png", str(tmp_path)), "from the nearest folder that is there"


def test_a_folder_is_located_for_all(dialog, files, asked, tmp_path, monkeypatch):
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: "")
    dialog.folder_button.click()
    asked.look.assert_not_called()
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "moved"))
    dialog.folder_button.click()
    asked.look.assert_called_once_with(tmp_path / "moved")


def test_only_a_changed_file_can_be_opened_as_a_new_frame(dialog, files, asked):
    assert not dialog.new_button.isEnabled()
    dialog.show_files([("hall", files[0]), ("stairs", files[1])], "b")
    dialog.new_button.click()
    asked.open_new.assert_called_once_with(files[1])


def test_during_a_search_nothing_else_is_asked_for(dialog, files, asked, qtbot):
    end = Event()
    asked.search.ask(end)
    assert not dialog.file_button.isEnabled()
    assert not dialog.folder_button.isEnabled()
    end.set()
    qtbot.waitUntil(dialog.file_button.isEnabled)
