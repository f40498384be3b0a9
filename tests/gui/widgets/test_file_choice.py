"""Files to write are chosen in the system's dialog, which asks before one is overwritten."""

import pytest
from PySide6.QtWidgets import QFileDialog

from gui.widgets.file_choice import ask_path


@pytest.mark.parametrize(
    ("typed", "asked_again", "written"),
    [("runs.txt", False, "runs.txt"), ("new", False, "new.csv"), ("runs", True, "runs.csv")],
)
def test_the_dialog_asks_about_the_whole_name_of_a_file_that_is_there(
    tmp_path, monkeypatch, typed, asked_again, written
):
    (tmp_path / "runs.csv").touch()
    proposed = []

    def choose(window, title, path, kinds):
        proposed.append(path)
        return (path if len(proposed) > 1 else str(tmp_path / typed)), "Table (*.csv)"

    monkeypatch.setattr(QFileDialog, "getSaveFileName", choose)
    assert ask_path(None, "Export", "runs.csv", "Table (*.csv)") == str(tmp_path / written)
    assert proposed[1:] == [str(tmp_path / written)] * asked_again


def test_a_folder_may_be_there_and_gets_no_suffix(tmp_path, monkeypatch):
    answers = [(str(tmp_path), "Folder (*)")]
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: answers.pop())
    assert ask_path(None, "Record", "recording.mcap", "ROS 2 recording (*.mcap);;Folder (*)") == str(tmp_path)
