"""A recording in the window: its frames are listed, looked at, kept in a project and made again from their record."""

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog
from pytestqt.qtbot import QtBot

from gui.app.main_window import MainWindow
from gui.features.frame_list.feature import FramesFeature
from ilf.sources.opening import close_all
from tests.ilf.bags import COLOUR, DEPTH, storage_of, write_aligned

from .conftest import answer, loaded, save
from .test_projects import open_project, show

KEYS = ("1600000000.000000000", "1600000000.033000000", "1600000000.066000000")


@pytest.fixture(autouse=True)
def nothing_left_open():
    yield
    close_all()


def _open(window: MainWindow, qtbot: QtBot, path: Path) -> None:
    loaded(window, qtbot, window.documents.open_paths, [path])


def test_frames_of_a_recording_are_listed_and_gone_through(window, qtbot, tmp_path):
    path = write_aligned(tmp_path, "ros1")
    window.recorder.start()
    _open(window, qtbot, path)
    entries, workspace = window.workspace.entries, window.workspace
    assert [entry.name for entry in entries] == [f"recording {key}" for key in KEYS]
    assert [entry.document is not None for entry in entries] == [True, False, False]
    assert np.array_equal(workspace.current.frame.rgb, COLOUR)
    picture_of = window.feature(FramesFeature).panel.picture_of
    qtbot.waitUntil(lambda: picture_of(entries[2]) is not None)
    picture = picture_of(entries[2])
    assert (picture.width(), picture.height()) == (160, 120)
    for key in KEYS[1:]:
        loaded(window, qtbot, window.actions_["next_frame"].trigger)
        assert workspace.current.frame.inputs.frame == key
    _open(window, qtbot, path)
    assert len(entries) == 3, "frames that are there already do not come again"


def test_a_project_brings_frames_of_a_recording_back(window, another, qtbot, tmp_path, monkeypatch):
    """With the work on them, without the recording in it, and from where the recording is later."""
    path = write_aligned(tmp_path, "mcap")
    window.recorder.start()
    _open(window, qtbot, path)
    workspace = window.workspace
    labels = np.zeros(DEPTH.shape, np.int32)
    labels[4:12, 4:20] = 1
    workspace.current.replace_blocks(labels, "Draw")
    workspace.set_note(workspace.entries[1], "glass")
    save(window, qtbot, tmp_path / "work.ilf", embed=True)
    assert (tmp_path / "work.ilf").stat().st_size < storage_of(tmp_path, "mcap").stat().st_size * 4
    close_all()
    (tmp_path / "away").mkdir()
    path.rename(tmp_path / "away" / path.name)

    again = another()
    window.project.present.release()
    open_project(again, qtbot, tmp_path / "work.ilf")
    answer(again, "Cancel")
    assert "Frames" in again.panels.open, "the frames are listed, though none can be shown"
    again.loader.open_entry(again.workspace.entries[0])
    qtbot.waitUntil(lambda: not again.loader.busy)
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path / "away"))
    loaded(again, qtbot, answer, again, "Locate f&older…")
    document = show(again, qtbot, 0)
    assert np.array_equal(document.labels, labels)
    assert document.frame.inputs.frame == KEYS[0]
    assert np.array_equal(document.frame.rgb, COLOUR)
    assert [entry.note for entry in again.workspace.entries] == ["", "glass", ""]
    assert show(again, qtbot, 2).frame.depth[0, 0] == np.float32(1.502)


def test_a_recording_that_cannot_be_read_is_one_message(window, qtbot, tmp_path):
    path = tmp_path / "cut.bag"
    path.write_bytes(write_aligned(tmp_path, "ros1", frames=1).read_bytes()[:3000])
    told: list[tuple[str, str]] = []
    window.notes.report = lambda what, error: told.append((what, str(error)))
    window.documents.open_paths([path])
    qtbot.waitUntil(lambda: bool(told))
    assert told[0][0] == "Looking for frames in cut.bag"
    assert "cut.bag is damaged" in told[0][1]
    assert not len(window.workspace.entries)
