"""Blocks go from frame to frame in the real window."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.carrying.part import CarryingPart
from gui.main_window import MainWindow
from gui.state.entries import Entry
from ilf.frame import RGBDFrame
from ilf.io.frame_source import FrameSource

from .conftest import WAIT_MS, open_frame, write_frame

SHIFT = 3


@pytest.fixture
def sequence(tmp_path: Path, small_frame: RGBDFrame) -> list[FrameSource]:
    """`small_frame` as a camera sees it that moves to the left, in five frames; the second stands still."""
    shifts = (0, 0, SHIFT, 2 * SHIFT, 3 * SHIFT)
    frames = [
        replace(
            small_frame,
            rgb=np.roll(small_frame.rgb, shift, axis=1),
            depth=np.roll(small_frame.depth, shift, axis=1),
        )
        for shift in shifts
    ]
    return [FrameSource(str(write_frame(tmp_path / f"frame-{number}", one))) for number, one in enumerate(frames)]


@pytest.fixture
def listed(window: MainWindow, qtbot: QtBot, sequence: list[FrameSource]) -> MainWindow:
    """The window with the sequence in its list, and the first frame open."""
    window.workspace.add_entries([Entry.of(source) for source in sequence])
    open_frame(window, qtbot, sequence[0])
    return window


def carrying(window: MainWindow) -> CarryingPart:
    return next(part for part in window.parts if isinstance(part, CarryingPart))


def carry(window: MainWindow, qtbot: QtBot, command: str) -> None:
    with qtbot.waitSignal(carrying(window).carrier.ended, timeout=WAIT_MS):
        window.actions_[command].trigger()
    window.refresh.now()


def test_a(listed: MainWindow, qtbot: QtBot) -> None:
    window, workspace = listed, listed.workspace
    first = workspace.session
    workspace.edit_info(1, "Rename", name="Wall", locked=True)
    workspace.set_own({"smoothness": 3.0}, [2])
    carry(window, qtbot, "carry_next")
    second = workspace.session
    assert second is not first and second.name == "frame-1"
    assert np.array_equal(second.labels, first.labels)
    print(second.infos, second.notes.own, workspace.entries[1].summary, second.undo_stack.undoText())
    carrying(window).carry_through(9)
    qtbot.waitUntil(lambda: carrying(window).carrier.journey is None, timeout=WAIT_MS)
    print([entry.summary for entry in workspace.entries])
