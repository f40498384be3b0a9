"""Playing a recording, a folder or a camera live: completed as it plays, recorded, and the frame shown opened."""

import re
import time
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

import ilf
from gui.base.commands import why_not
from gui.features.sequence.playing import PlayFeature
from gui.features.status import StatusFeature
from gui.work.jobs import stop_workers
from ilf._runtime.long_work import check_cancelled
from ilf.errors import InputError
from ilf.sources.realsense import load_realsense

from ..ilf.bags import write_aligned
from ..ilf.software_camera import connect

FRAMES = 6


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_aligned(tmp_path_factory.mktemp("live"), "mcap", frames=FRAMES)


@pytest.fixture
def answers(monkeypatch):
    """What the user answers when asked where to write, one after the other; then nothing."""
    given = []
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (given.pop(0) if given else "", ""))
    return given


def _played(window, qtbot, path: Path | None, rate: float) -> list:
    """Play to the end; return the frames shown."""
    feature, shown = window.feature(PlayFeature), []
    feature.worker.progressed.connect(shown.extend)
    feature.play_live(None if path is None else str(path), rate)
    qtbot.waitUntil(lambda: not feature.playing and not feature.worker.busy)
    feature.worker.progressed.disconnect(shown.extend)
    return shown


def test_frames_are_shown_recorded_and_counted_and_the_last_one_is_opened(window, qtbot, recording, tmp_path, answers):
    said, status = [], window.feature(StatusFeature)
    window.feature(PlayFeature).worker.progressed.connect(lambda _: said.append(status.bar.hint.text()))
    answers.append(str(tmp_path / "out.mcap"))
    window.actions_["play_recorded"].trigger()
    shown = _played(window, qtbot, recording, 5.0)
    last = shown[-1]
    assert len(shown) + last.left_out == FRAMES
    assert len(shown) >= 2  # the first and the last
    assert (last.completing.frames, last.completing.scenes, last.recorded) == (len(shown), 1, len(shown))
    assert re.search(r"latency [1-9]\d* ms \(95 %: [1-9]\d* ms\)", said[-1])
    assert f"{last.recorded} frames recorded" in said[-1]
    recorded = [frame.depth for frame in ilf.open_source(tmp_path / "out.mcap")]
    assert len(recorded) == len(shown)
    assert np.array_equal(recorded[-1], last.moment.depth)
    assert not window.actions_["play_recorded"].isChecked(), "it ends with playing"
    assert f"{len(shown)} frames recorded: {tmp_path / 'out.mcap'}" in window.notes.message
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
    opened = window.workspace.current.frame
    assert np.array_equal(opened.depth, last.moment.frame.depth, equal_nan=True)


def test_what_cannot_be_played_or_recorded_is_told_and_the_former_frame_is_shown(opened, qtbot, tmp_path, answers):
    told, former = [], opened.workspace.current
    opened.notes.reported.connect(told.append)
    assert _played(opened, qtbot, tmp_path / "none", 10.0) == []
    assert "none" in told[-1]
    qtbot.waitUntil(lambda: opened.workspace.shown is not None)
    assert opened.workspace.current is former
    taken = tmp_path / "taken.mcap"
    taken.touch()
    answers.append(str(taken))
    opened.actions_["play_recorded"].trigger()
    assert "already exists" in told[-1]
    assert not opened.actions_["play_recorded"].isChecked()
    assert taken.stat().st_size == 0


def test_a_camera_is_played_and_recorded_until_it_is_lost_and_its_last_frame_kept(
    window, qtbot, tmp_path, monkeypatch, answers
):
    try:
        library = load_realsense()
    except InputError as error:
        pytest.skip(str(error))
    told = []
    window.notes.reported.connect(told.append)
    assert _played(window, qtbot, None, 10.0) == []
    assert "No RealSense camera is connected" in told[-1]
    (tmp_path / "taken.d").mkdir()
    (tmp_path / "taken.d" / "rgb.png").touch()
    answers += [str(tmp_path / "out.mcap"), str(tmp_path / "taken.d"), str(tmp_path / "kept")]
    camera = connect(library, monkeypatch, last=34)
    window.actions_["play_recorded"].trigger()
    shown = _played(window, qtbot, None, 1000.0)
    assert not camera.running
    qtbot.waitUntil(lambda: window.workspace.shown is not None)
    assert "sent no frame" in told[1]
    assert "Reconnect it" in told[1]
    assert "already exists" in told[2], "another folder was asked for"
    last = shown[-1].moment.frame
    assert np.array_equal(window.workspace.current.frame.depth, last.depth, equal_nan=True)
    recorded = ilf.open_source(tmp_path / "out.mcap")
    assert len(recorded) == len(shown)
    assert recorded.read(recorded.keys[-1]).intrinsics == last.intrinsics


def test_a_frame_of_a_camera_is_written_also_when_the_window_closes_and_not_if_the_user_cancels(
    window, qtbot, small_frame, monkeypatch, tmp_path, answers
):
    def write(path, frame):
        time.sleep(0.3)
        check_cancelled()
        Path(path).touch()

    feature = window.feature(PlayFeature)
    monkeypatch.setattr("gui.features.sequence.playing.write_frame", write)
    monkeypatch.setattr("gui.features.sequence.live._captured", lambda: _camera(small_frame))
    shown = _played(window, qtbot, None, 10.0)
    assert np.array_equal(shown[-1].moment.frame.rgb, small_frame.rgb)
    qtbot.waitUntil(lambda: window.views.data.frame is None)  # the start page is shown
    answers.append(str(tmp_path / "kept"))
    _played(window, qtbot, None, 10.0)
    stop_workers(feature)
    assert (tmp_path / "kept").exists()


def test_why_no_frame_can_be_played_is_told(window, qtbot, monkeypatch, tmp_path):
    told = []
    window.notes.reported.connect(told.append)
    folder = write_aligned(tmp_path, "mcap", frames=2)

    def fail(*_):
        raise InputError("It is wet. Dry it.")

    monkeypatch.setattr("gui.features.sequence.live.read_frame", fail)
    assert _played(window, qtbot, folder, 10.0) == []
    assert "It is wet. Dry it." in told[-1]


def test_playing_live_leaves_no_setting_and_closing_the_window_no_empty_file(
    window, qtbot, small_frame, monkeypatch, tmp_path, answers
):
    monkeypatch.setattr("gui.features.sequence.live._captured", lambda: _camera(small_frame))
    _played(window, qtbot, None, 10.0)
    assert not window.actions_["play_completed"].isChecked()
    answers.append(str(tmp_path / "out.mcap"))
    window.actions_["play_recorded"].trigger()
    assert (tmp_path / "out.mcap").exists()
    window.close()
    assert not (tmp_path / "out.mcap").exists()


def _camera(frame):
    from gui.features.sequence.live import _moments

    yield from _moments("camera", [lambda: frame])


def test_the_menu_plays_a_recording_a_folder_or_a_camera(another, tmp_path, monkeypatch):
    monkeypatch.setattr("gui.features.sequence.playing.find_spec", lambda _: None)
    window, asked = another(), []
    monkeypatch.setattr(PlayFeature, "play_live", lambda self, path=None: asked.append(path))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "a.mcap"), ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path))
    for name in ("play_recording", "play_folder"):
        window.actions_[name].trigger()
    assert asked == [str(tmp_path / "a.mcap"), str(tmp_path)]
    camera = window.actions_["play_camera"]
    assert not camera.isEnabled()
    assert "ilf-studio[sensors]" in why_not(camera)
    monkeypatch.setattr("gui.features.sequence.playing.find_spec", lambda _: object())
    camera.trigger()
    assert asked[2:] == [None]
