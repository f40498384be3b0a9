"""What was opened last is offered again, as it was read, in this session and the next."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QSettings

from gui.features.project.recent import MOST, RecentOrigins, is_missing, name_of
from ilf.data.camera import CameraIntrinsics
from ilf.sources.frame_source import FrameSource

pytestmark = pytest.mark.usefixtures("qapp")


def test_the_last_comes_first_once_and_how_it_was_read_is_kept(tmp_path: Path) -> None:
    frames = RecentOrigins("frames", persistent=True)
    folder, record = FrameSource(str(tmp_path)), tmp_path / "out" / "run.json"
    colour, depth, ground_truth, guide = (str(tmp_path / name) for name in ("a.png", "b.png", "t.npy", "g.npy"))
    pair = FrameSource(colour, depth, 5000.0, (525.0, 525.0, 319.5, 239.5), ground_truth, 1.0, guide)
    for origin in (folder, pair, record, folder):
        frames.note(origin)
    later = RecentOrigins("frames", persistent=True)
    assert later.origins == [folder, record, pair]
    assert [name_of(origin) for origin in later.origins] == [tmp_path.name, "out/run.json", f"{tmp_path.name}/a.png"]
    assert [is_missing(origin) for origin in later.origins] == [False, True, True]
    later.remove_missing()
    assert RecentOrigins("frames", persistent=True).origins == [folder]
    for number in range(MOST + 3):
        later.note(FrameSource(str(tmp_path / str(number))))
    assert len(later.origins) == MOST


def test_what_settings_cannot_hold_costs_no_other(tmp_path: Path) -> None:
    frames = RecentOrigins("frames", persistent=True)
    frames.note(FrameSource(str(tmp_path)))
    frames.note(FrameSource("a.png", "b.png", intrinsics=CameraIntrinsics(1, 1, 0, 0)))
    assert RecentOrigins("frames", persistent=True).origins == [FrameSource(str(tmp_path))]


def test_a_window_that_does_not_remember_neither_reads_nor_writes(tmp_path: Path) -> None:
    RecentOrigins("frames", persistent=True).note(FrameSource(str(tmp_path)))
    apart = RecentOrigins("frames", persistent=False)
    assert apart.origins == []
    apart.note(FrameSource("elsewhere"))
    assert RecentOrigins("frames", persistent=True).origins == [FrameSource(str(tmp_path))]


@pytest.mark.parametrize("kept", ["", "{", "[1]", '[{"rgb": "a"}]', '[{"file": 7}]', "7", "[" * 10**5])
def test_settings_that_are_damaged_offer_nothing(kept: str) -> None:
    QSettings().setValue("recent/frames", kept)
    assert RecentOrigins("frames", persistent=True).origins == []
