"""The window that plays a recording: pictures, figures, recording, freezing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QWidget

import ilf
from gui.features.live import LiveWindow
from tests.ilf.bags import write_aligned

FRAMES = 6


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_aligned(tmp_path_factory.mktemp("live"), "mcap", frames=FRAMES)


@pytest.fixture
def live(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    window = LiveWindow(parent)
    yield window
    window.close()
    qtbot.waitUntil(lambda: not window.worker.busy)


def played(qtbot, window: LiveWindow, path: Path, rate: float) -> None:
    window.show()
    window.play(str(path), rate, ilf.preset("best"))
    qtbot.waitUntil(lambda: window.play_button.text() == "&Play again", timeout=60_000)


def test_frames_are_shown_recorded_and_counted(qtbot, live, recording, tmp_path) -> None:
    out = tmp_path / "out.mcap"
    live.record(out)
    played(qtbot, live, recording, 2.0)
    assert live.shown is not None
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


def test_a_frozen_frame_is_the_one_shown(qtbot, live, recording) -> None:
    played(qtbot, live, recording, 1000.0)
    frozen = []
    live.frozen.connect(frozen.append)
    live.freeze()
    assert live.shown is not None
    assert np.array_equal(frozen[0].load().depth, live.shown.completion.frame.depth, equal_nan=True)


def test_what_cannot_be_played_or_recorded_is_told(qtbot, live, recording, tmp_path) -> None:
    played(qtbot, live, tmp_path / "none", 10.0)
    assert "none" in live.state.text()
    taken = tmp_path / "taken.mcap"
    taken.touch()
    live.record(taken)
    played(qtbot, live, recording, 1000.0)
    assert "already exists" in live.state.text()
    assert live.record_button.text() == "&Record…"
    assert taken.stat().st_size == 0
