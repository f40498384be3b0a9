"""Frames of recordings of ROS 1 and ROS 2: which belong together, what they are read as, and what is damaged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.io.recordings import close_all
from tests.ilf.bags import COLOUR, DEPTH, KINDS, START, storage_of, write_aligned


def in_metres(millimetres: np.ndarray) -> np.ndarray:
    return np.where(millimetres > 0, millimetres / 1000, np.nan).astype(np.float32)


@pytest.fixture(autouse=True)
def nothing_left_open() -> Iterator[None]:
    yield
    close_all()


@pytest.mark.parametrize("kind", KINDS)
def test_aligned_depth_of_every_kind_of_bag(tmp_path: Path, kind: str) -> None:
    source = ilf.open_source(write_aligned(tmp_path, kind))
    start = START // 10**9
    assert source.keys == (f"{start}.000000000", f"{start}.033000000", f"{start}.066000000")
    assert source.timestamps == pytest.approx([start, start + 0.033, start + 0.066], abs=1e-6)
    assert source.is_registered
    assert source.notes == ()
    frame = source.read(source.keys[1])
    assert np.array_equal(frame.rgb, COLOUR + 1)
    assert np.array_equal(frame.depth, in_metres(DEPTH + np.uint16(DEPTH > 0)), equal_nan=True)
    assert frame.name == f"recording {source.keys[1]}"
    camera = source.calibration(source.keys[0])
    assert camera.colour == camera.depth == frame.intrinsics
    assert (frame.intrinsics.fx, frame.intrinsics.cx) == (30, 15.5)
    again = ilf.load_frame(**frame.sources)
    assert again.inputs == frame.inputs
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
def test_a_file_of_ros_2_without_its_folder(tmp_path: Path, kind: str) -> None:
    whole = ilf.open_source(write_aligned(tmp_path, kind))
    alone = ilf.open_source(storage_of(tmp_path, kind))
    assert alone.keys == whole.keys
    assert alone.read(alone.keys[2]).inputs.depth.sha256 == whole.read(whole.keys[2]).inputs.depth.sha256


def test_a_raw_pair_of_registered_frames_has_one_camera(tmp_path: Path) -> None:
    source = ilf.open_source(write_aligned(tmp_path, "ros1"))
    pair = source.read(source.keys[0], registered=False)
    assert pair.colour_camera == pair.depth_camera
    assert np.array_equal(pair.depth, in_metres(DEPTH), equal_nan=True)
