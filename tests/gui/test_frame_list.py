"""The list of frames reports clicks and closes nothing by itself."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt

from gui.frames.frame_list import FrameList


@pytest.fixture
def frames(qtbot):
    frames = FrameList()
    qtbot.addWidget(frames)
    frames.resize(260, 240)
    for key in ("a", "b", "c"):
        frames.add_frame(key, f"Frame {key}", np.full((30, 40, 3), 90, np.uint8), "640 x 480, 12% missing")
    frames.set_current("a")
    frames.show()
    qtbot.waitExposed(frames)
    return frames


def _row(frames: FrameList, row: int):
    return frames.view.visualItemRect(frames.view.item(row))


def test_click_activates_another_frame_only(frames, qtbot):
    viewport = frames.view.viewport()
    with qtbot.assertNotEmitted(frames.activated):
        qtbot.mouseClick(viewport, Qt.MouseButton.LeftButton, pos=_row(frames, 0).center())
        frames.set_current("c")
    with qtbot.waitSignal(frames.activated) as blocker:
        qtbot.mouseClick(viewport, Qt.MouseButton.LeftButton, pos=_row(frames, 1).center())
    assert blocker.args == ["b"]


def test_cross_asks_to_close_and_activates_nothing(frames, qtbot):
    at = _row(frames, 2).topRight() + QPoint(-14, 14)
    with qtbot.assertNotEmitted(frames.activated), qtbot.waitSignal(frames.removeRequested) as blocker:
        qtbot.mouseClick(frames.view.viewport(), Qt.MouseButton.LeftButton, pos=at)
    assert blocker.args == ["c"]
    assert frames.keys() == ["a", "b", "c"]


def test_remove_and_add_again(frames):
    frames.remove_frame("a")
    assert frames.keys() == ["b", "c"]
    with pytest.raises(ValueError, match="already"):
        frames.add_frame("b", "again", np.zeros((2, 2, 3), np.uint8))
    frames.add_frame("a", "again", np.zeros((2, 2, 3), np.uint8))
    assert frames.keys() == ["b", "c", "a"]


def test_empty_list_says_what_to_do(frames):
    before = frames.grab().toImage()
    for key in frames.keys():  # noqa: SIM118
        frames.remove_frame(key)
    empty = frames.grab().toImage()
    colours = {empty.pixel(x, y) for x in range(empty.width()) for y in range(90, 150)}
    assert len(colours) > 1, "the hint is not painted"
    assert empty != before
