"""Recordings of RealSense cameras: those of the Viewer in ROS 1, written here, and what the maker's library records."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.errors import FormatError
from ilf.io.recordings import close_all
from tests.ilf.bags import COLOUR, DEPTH, H, W, bag

STREAMS = {"depth": "/device_0/sensor_0/Depth_0", "colour": "/device_0/sensor_1/Color_0"}


@pytest.fixture(autouse=True)
def nothing_left_open() -> Iterator[None]:
    yield
    close_all()


def _write_viewer_bag(folder: Path, units: float = 0.001, option: str = "Depth Units") -> Path:
    """The Viewer's layout: one coordinate frame "0" for all, and transforms from a group of streams to each."""
    turn = (0.0, math.sin(0.01), 0.0, math.cos(0.01))
    with bag(folder, "ros1") as out:
        unit = out.make("std_msgs/msg/Float32", units)
        out.write(f"/device_0/sensor_0/option/{option}/value", unit, 0)
        for stream, shift in (("depth", (0.0, 0.0, 0.0)), ("colour", (0.015, 0.0, 0.0))):
            out.info(f"{STREAMS[stream]}/info/camera_info")
            out.write(f"{STREAMS[stream]}/tf/0", out.transform(shift, turn), 0)
        for number in range(2):
            stamp = number * 33_000_000
            out.image(f"{STREAMS['depth']}/image/data", DEPTH, "mono16", stamp + 1_000_000, "0")
            out.image(f"{STREAMS['colour']}/image/data", COLOUR + np.uint8(number), "rgb8", stamp, "0")
            out.image("/device_0/sensor_0/Infrared_1/image/data", COLOUR[..., 0], "8UC1", stamp, "0")
    return folder / "recording.bag"


@pytest.mark.parametrize("option", ["Depth Units", "Depth_Units"])
def test_a_bag_of_the_viewer(tmp_path: Path, option: str) -> None:
    source = ilf.open_source(_write_viewer_bag(tmp_path, option=option))
    assert len(source) == 2
    assert source.notes == ()
    assert not source.is_registered, "same size and same frame mean nothing here"
    expected = np.eye(4)
    expected[:3, 3] = 0.015, 0, 0  # both have the same turn, and depth stands where its group does
    assert source.calibration(source.keys[0]).depth_to_colour == pytest.approx(expected, abs=1e-9)
    pair = source.read(source.keys[1], registered=False)
    assert np.array_equal(pair.rgb, COLOUR + 1)
    assert pair.depth[0, 0] == np.float32(1.5)
    assert source.read(source.keys[1]).shape == (H, W)


def test_depth_units_of_the_camera_count(tmp_path: Path) -> None:
    source = ilf.open_source(_write_viewer_bag(tmp_path, units=0.0001))
    pair = source.read(source.keys[0], registered=False)
    assert pair.depth[0, 0] == np.float32(0.15)
    assert pair.inputs.depth_units == 10_000


def test_depth_units_that_are_none(tmp_path: Path) -> None:
    path = _write_viewer_bag(tmp_path, units=float("nan"))
    source = ilf.open_source(path)
    with pytest.raises(FormatError, match=f"{path}: its depth units are .*nan"):
        source.read(source.keys[0])
