"""The window that plays a recording or a camera: pictures, figures, recording, freezing."""

import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtWidgets import QFileDialog

import ilf
from gui.app.main_window import MainWindow
from gui.base.commands import why_not
from gui.features.live import LiveFeature
from gui.work.jobs import stop_workers
from ilf._runtime.cancellation import check_cancelled
from ilf.errors import InputError
from ilf.sources.reading import read_frame
from ilf.sources.realsense import load_realsense
from tests.ilf.bags import write_aligned
from tests.ilf.software_camera import connect

FRAMES = 6


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return write_aligned(tmp_path_factory.mktemp("live"), "mcap", frames=FRAMES)


@pytest.fixture
def live(qtbot, context):
    live = LiveFeature(context)
    yield live
    live.widget.close()
    qtbot.waitUntil(lambda: not live.busy)


@pytest.fixture
def frozen(live, monkeypatch):
    opened = []
    monkeypatch.setattr(live, "open_frozen", opened.append)
    return opened


def played(qtbot, live: LiveFeature, path: Path | None, rate: float) -> None:
    live.context.workspace.parameters.set(ilf.preset("best"))
    live.play(None if path is None else str(path), rate)
    qtbot.waitUntil(lambda: live.play_button.text() == "&Play again")


def test_frames_are_shown_recorded_and_counted(qtbot, live, recording, tmp_path):
    out = tmp_path / "out.mcap"
    live.record(out)
    played(qtbot, live, recording, 5.0)
    found = live.shown.statistics
    assert found.frames + found.dropped == FRAMES
    assert found.frames >= 2  # the first and the last
    assert "The recording has ended." in live.state.text()
    assert f"{found.dropped} dropped, 1 scene" in live.state.text()
    assert all(not picture.pixmap().isNull() for picture in live.pictures.values())
    assert live.shown.recorded == found.frames
    recorded = [frame.depth for frame in ilf.open_source(out)]
    assert len(recorded) == found.frames
    assert np.array_equal(recorded[-1], live.shown.completion.depth)


def test_frames_that_come_faster_than_they_can_be_drawn_are_left_out(qtbot, live, recording, monkeypatch):
    played(qtbot, live, recording, 1000.0)
    drawn, frame = [], live.shown
    monkeypatch.setattr(live.pictures["Colour"], "show_rgb", drawn.append)
    monkeypatch.setattr("gui.features.live.play", lambda *_: (yield from [frame] * 100))
    played(qtbot, live, recording, 1000.0)
    assert 1 <= len(drawn) < 50


def test_a_frozen_frame_is_the_one_shown(qtbot, live, recording, frozen):
    played(qtbot, live, recording, 1000.0)
    live.freeze()
    assert np.array_equal(read_frame(frozen[0]).depth, live.shown.completion.frame.depth, equal_nan=True)


def test_what_cannot_be_played_or_recorded_is_told(qtbot, live, recording, tmp_path):
    played(qtbot, live, tmp_path / "none", 10.0)
    assert "none" in live.state.text()
    taken = tmp_path / "taken.mcap"
    taken.touch()
    live.record(taken)
    played(qtbot, live, recording, 1000.0)
    assert "already exists" in live.state.text()
    assert live.record_button.text() == "&Record…"
    assert taken.stat().st_size == 0


def test_a_camera_is_played_recorded_and_frozen_until_it_is_lost(qtbot, live, tmp_path, monkeypatch, frozen):
    try:
        library = load_realsense()
    except InputError as error:
        pytest.skip(str(error))
    played(qtbot, live, None, 10.0)
    assert "No RealSense camera is connected" in live.state.text()
    camera, out = connect(library, monkeypatch, last=34), tmp_path / "out.mcap"
    live.record(out)
    played(qtbot, live, None, 1000.0)
    assert "sent no frame" in live.state.text()
    assert "Reconnect it" in live.state.text()
    assert not camera.running
    last = live.shown.completion.frame
    recorded = ilf.open_source(out)
    assert len(recorded) == live.shown.statistics.frames
    assert recorded.read(recorded.keys[-1]).intrinsics == last.intrinsics
    answers = ["", str(tmp_path / "frozen"), str(tmp_path / "frozen")]
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (answers.pop(0), ""))
    live.freeze()
    assert frozen == [], "cancelled"
    live.freeze()
    qtbot.waitUntil(lambda: len(frozen) == 1)
    assert np.array_equal(read_frame(frozen[0]).depth, last.depth, equal_nan=True)
    live.freeze()
    qtbot.waitUntil(lambda: "already exists" in live.state.text())
    assert len(frozen) == 1


def test_a_frame_that_is_being_frozen_is_written_when_the_window_closes(live, small_frame, monkeypatch, tmp_path):
    def write(path, frame):
        time.sleep(0.3)
        check_cancelled()
        Path(path).touch()

    path = tmp_path / "frozen"
    monkeypatch.setattr("gui.features.live.write_frame", write)
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    live.shown = SimpleNamespace(completion=SimpleNamespace(frame=small_frame))
    live.freeze()
    stop_workers(live)
    assert path.exists()


def test_the_menu_plays_a_recording_a_folder_or_a_camera(qtbot, tmp_path, monkeypatch):
    monkeypatch.setattr("gui.features.on_use.find_spec", lambda _: None)
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    asked = []
    monkeypatch.setattr(window.feature(LiveFeature), "play", lambda path, *_: asked.append(path))
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(tmp_path / "a.mcap"), ""))
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(tmp_path))
    for name in ("play_recording", "play_folder"):
        window.actions_[name].trigger()
    assert asked == [str(tmp_path / "a.mcap"), str(tmp_path)]
    camera = window.actions_["play_camera"]
    assert not camera.isEnabled()
    assert "ilf-studio[sensors]" in why_not(camera)
    monkeypatch.setattr("gui.features.on_use.find_spec", lambda _: object())
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    monkeypatch.setattr(window.feature(LiveFeature), "play", lambda path=None, *_: asked.append(path))
    window.actions_["play_camera"].trigger()
    assert asked[2:] == [None]
    window.close()
