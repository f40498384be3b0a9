"""Recordings of RealSense cameras: those of the Viewer in ROS 1, written here, and what the maker's library records."""

from __future__ import annotations

import math
import sys
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import InputError
from ilf.sources.realsense import camera_pairs, capture_frame, load_realsense, pair_of
from ilf.sources.registration import register
from tests.ilf.bags import COLOUR, DEPTH, H, W
from tests.ilf.realsense_bags import SHIFTS, write_library_db3, write_viewer_bag
from tests.ilf.software_camera import connect


@pytest.mark.parametrize("option", ["Depth Units", "Depth_Units"])
def test_a_bag_of_the_viewer(tmp_path, option):
    source = ilf.open_source(write_viewer_bag(tmp_path, option=option))
    assert len(source) == 2
    assert source.notes == ()
    assert not source.is_registered, "same size and same frame mean nothing here"
    expected = np.eye(4)
    expected[:3, 3] = 0.015, 0, 0  # both have the same turn, and depth stands where its group does
    assert source.calibration(source.keys[0]).depth_to_colour == pytest.approx(expected, abs=1e-9)
    pair = source.read_pair(source.keys[1])
    assert np.array_equal(pair.rgb, COLOUR + 1)
    assert pair.depth[0, 0] == np.float32(1.5)
    assert source.read(source.keys[1]).shape == (H, W)


@pytest.mark.parametrize("silent", ["depth", "colour"])
def test_a_transform_without_a_message_says_nothing(tmp_path, silent):
    source = ilf.open_source(write_viewer_bag(tmp_path, silent=silent))
    with pytest.raises(InputError, match="lacks the transform between the two"):
        source.read(source.keys[0])


def test_depth_units_of_the_camera_count(tmp_path):
    source = ilf.open_source(write_viewer_bag(tmp_path, units=0.0001))
    pair = source.read_pair(source.keys[0])
    assert pair.depth[0, 0] == np.float32(0.15)
    assert pair.inputs.depth_units == 10_000


# the library of the maker, with a device of software


@pytest.fixture
def library():
    """pyrealsense2, where it is there."""
    try:
        return load_realsense()
    except InputError as error:
        pytest.skip(str(error))


def test_a_frame_of_a_device(library, tmp_path, monkeypatch):
    """What comes of a device of software is what was shown to it, and lies in a folder as every other frame."""
    software = connect(library, monkeypatch)
    with closing(camera_pairs(settle=0)) as pairs:
        pair = next(pairs)
        assert len(software.running) == 2
    assert not software.running
    assert pair.depth[0, 0] == pytest.approx(1.5 + pair.rgb[0, 0, 0] / 1000)  # both of one moment
    assert (pair.depth_camera.fx, pair.colour_camera.fx) == (25, 30)
    assert pair.depth_to_colour[:2, :2] == pytest.approx(
        np.array([[math.cos(0.004), -math.sin(0.004)], [math.sin(0.004), math.cos(0.004)]]), abs=1e-6
    )
    assert main(["capture", str(tmp_path / "taken"), "--settle", "2"]) == 0
    frame = ilf.load_frame(tmp_path / "taken")
    assert (frame.shape, frame.intrinsics.fx) == ((H, W), 30)
    assert np.nanmedian(frame.depth) == pytest.approx(np.nanmedian(register(pair).depth), abs=0.01)
    assert main(["capture", str(tmp_path / "taken"), "--settle", "1"]) == 1


def test_frames_come_until_the_camera_is_lost(library, monkeypatch):
    software = connect(library, monkeypatch, last=5)
    pairs = camera_pairs(settle=2)
    assert next(pairs).depth[0, 0] >= np.float32(1.502)
    with pytest.raises(InputError, match=r"sent no frame \(.*\)\. Reconnect it"):
        list(pairs)
    assert not software.running


def test_no_camera_is_one_message(library, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = cli("capture", "none", status=1).err
    assert said.startswith("ilf: error: No RealSense camera is connected")
    assert said.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_the_librarys_layout_as_it_is_written_here(tmp_path):
    source = ilf.open_source(write_library_db3(tmp_path))
    assert len(source) == 2
    assert source.calibration(source.keys[0]).depth_to_colour[:3, 3] == pytest.approx(
        -np.array(SHIFTS["colour"]), abs=1e-3
    )
    pair = source.read_pair(source.keys[1])
    assert np.array_equal(pair.rgb, COLOUR + 1)
    assert (pair.depth[0, 0], pair.inputs.depth_units) == (1.5, 1000)


def test_without_the_library(monkeypatch, cli):
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(InputError, match=r"needs the package pyrealsense2, .*ilf-studio\[sensors\]"):
        capture_frame()
    assert "ilf-studio[sensors]" in cli("capture", "none", status=1).err


class _SeenFrame:
    """A frame as the library gives it, of a camera with a lens."""

    def __init__(self, pixels: np.ndarray, model: str, coefficients: list[float]) -> None:
        intrinsics = {"fx": 30.0, "fy": 30.0, "ppx": 15.5, "ppy": 11.5, "width": W, "height": H}
        self.intrinsics = SimpleNamespace(**intrinsics, model=SimpleNamespace(name=model), coeffs=coefficients)
        self.profile, self.get_units = self, lambda: 0.001
        self.get_data = lambda: pixels

    def as_video_stream_profile(self) -> _SeenFrame:
        return self

    def get_extrinsics_to(self, _other: object) -> SimpleNamespace:
        return SimpleNamespace(rotation=np.eye(3).ravel(), translation=[0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("model", "lens"),
    [
        ("kannala_brandt4", ("fisheye", (0.05, -0.01, 0.004, -0.001))),
        ("inverse_brown_conrady", ("pinhole", (0.05, -0.01, 0.004, -0.001, 0.0))),
        ("ftheta", None),
    ],
)
def test_the_lens_of_a_camera_is_that_of_its_model(model, lens):
    coefficients = [0.05, -0.01, 0.004, -0.001, 0.0]
    frames = SimpleNamespace(
        get_depth_frame=lambda: _SeenFrame(DEPTH, "brown_conrady", [0.0] * 5),
        get_color_frame=lambda: _SeenFrame(COLOUR, model, coefficients),
    )
    if lens is None:
        with pytest.raises(InputError, match="'ftheta' is not supported"):
            pair_of(frames)
        return
    camera = pair_of(frames).colour_camera
    assert (camera.model, camera.distortion) == lens
