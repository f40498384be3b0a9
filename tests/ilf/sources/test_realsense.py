"""Recordings of RealSense cameras: those of the Viewer in ROS 1, written here, and what the maker's library records."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import ilf
from ilf.cli import main
from ilf.errors import FormatError, InputError
from ilf.sources.opening import close_all
from ilf.sources.realsense import capture_frame, load_realsense, pair_of
from ilf.sources.registration import register
from tests.ilf.bags import COLOUR, DEPTH, H, W
from tests.ilf.realsense_bags import SHIFTS, write_library_db3, write_viewer_bag


@pytest.fixture(autouse=True)
def nothing_left_open() -> Iterator[None]:
    yield
    close_all()


@pytest.mark.parametrize("option", ["Depth Units", "Depth_Units"])
def test_a_bag_of_the_viewer(tmp_path: Path, option: str) -> None:
    source = ilf.open_source(write_viewer_bag(tmp_path, option=option))
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


@pytest.mark.parametrize("silent", ["depth", "colour"])
def test_a_transform_without_a_message_says_nothing(tmp_path: Path, silent: str) -> None:
    source = ilf.open_source(write_viewer_bag(tmp_path, silent=silent))
    with pytest.raises(InputError, match="lacks the transform between the two"):
        source.read(source.keys[0])


def test_depth_units_of_the_camera_count(tmp_path: Path) -> None:
    source = ilf.open_source(write_viewer_bag(tmp_path, units=0.0001))
    pair = source.read(source.keys[0], registered=False)
    assert pair.depth[0, 0] == np.float32(0.15)
    assert pair.inputs.depth_units == 10_000


def test_depth_units_that_are_none(tmp_path: Path) -> None:
    path = write_viewer_bag(tmp_path, units=float("nan"))
    source = ilf.open_source(path)
    with pytest.raises(FormatError, match=f"{path}: its depth units are .*nan"):
        source.read(source.keys[0])


# the library of the maker, with a device of software


@pytest.fixture
def library() -> Any:
    """pyrealsense2, where it is there."""
    try:
        return load_realsense()
    except InputError as error:
        pytest.skip(str(error))


class SoftwareDevice:
    """A device of software with a depth and a colour camera, 15 mm apart."""

    def __init__(self, library: Any) -> None:
        self.library = library
        self.device = library.software_device()
        self.sensors = {name: self.device.add_sensor(name) for name in ("Stereo Module", "RGB Camera")}
        stereo, colour = self.sensors.values()
        stereo.add_read_only_option(library.option.depth_units, 0.001)
        self.depth_profile = stereo.add_video_stream(self._stream(library.stream.depth, library.format.z16, 2, 25.0))
        self.colour_profile = colour.add_video_stream(self._stream(library.stream.color, library.format.rgb8, 3, 30.0))
        motion = library.extrinsics()
        # a quarter of a degree about the viewing axis, column by column
        sine, cosine = math.sin(0.004), math.cos(0.004)
        motion.rotation, motion.translation = [cosine, sine, 0, -sine, cosine, 0, 0, 0, 1], [0.015, 0, 0]
        self.depth_profile.register_extrinsics_to(self.colour_profile, motion)
        self._kept: list[np.ndarray] = []

    def _stream(self, kind: Any, pixels: Any, size: int, focal: float) -> Any:
        seen = self.library.intrinsics()
        seen.width, seen.height, seen.fx, seen.fy, seen.ppx, seen.ppy = W, H, focal, focal, 15.5, 11.5
        seen.model, seen.coeffs = self.library.distortion.brown_conrady, [0.0] * 5
        stream = self.library.video_stream()
        stream.type, stream.index, stream.uid, stream.fps = kind, 0, size, 30
        stream.width, stream.height, stream.bpp, stream.fmt, stream.intrinsics = W, H, size, pixels, seen
        return stream

    def show(self, number: int) -> None:
        """Send a frame."""
        stereo, colour = self.sensors.values()
        for sensor, profile, pixels in (
            (stereo, self.depth_profile, DEPTH + np.uint16(number) * (DEPTH > 0)),
            (colour, self.colour_profile, COLOUR + np.uint8(number)),
        ):
            pixels = np.ascontiguousarray(pixels)
            self._kept.append(pixels)  # the library does not copy them
            frame = self.library.software_video_frame()
            frame.pixels, frame.bpp = pixels, pixels.nbytes // (W * H)
            frame.stride, frame.timestamp = W * frame.bpp, 33.0 * number
            frame.domain, frame.frame_number = self.library.timestamp_domain.system_time, number
            frame.profile = profile.as_video_stream_profile()
            if sensor is stereo:
                frame.depth_units = 0.001
            sensor.on_video_frame(frame)


def test_a_frame_of_a_device(library: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What comes of a device of software is what was shown to it, and lies in a folder as every other frame."""
    software = SoftwareDevice(library)
    software.device.create_matcher(library.matchers.default)
    syncer = library.syncer()
    for sensor in software.sensors.values():
        sensor.open(sensor.get_stream_profiles())
        sensor.start(syncer)
    shown = 0

    class Pipeline:
        def start(self, wish: Any) -> None: ...

        def wait_for_frames(self, patience: int) -> Any:
            nonlocal shown
            while True:
                software.show(shown)
                shown += 1
                frames = syncer.wait_for_frames(patience)
                if frames.get_depth_frame() and frames.get_color_frame():
                    return frames

        def stop(self) -> None:
            for sensor in software.sensors.values():
                sensor.stop()
                sensor.close()

    pair = pair_of(Pipeline().wait_for_frames(1000))
    assert pair.depth[0, 0] == pytest.approx(1.5 + pair.rgb[0, 0, 0] / 1000)  # both of one moment
    assert (pair.depth_camera.intrinsics.fx, pair.colour_camera.intrinsics.fx) == (25, 30)
    assert pair.depth_to_colour[:2, :2] == pytest.approx(
        np.array([[math.cos(0.004), -math.sin(0.004)], [math.sin(0.004), math.cos(0.004)]]), abs=1e-6
    )
    monkeypatch.setattr(library, "pipeline", Pipeline)
    monkeypatch.setattr(library, "context", lambda: SimpleNamespace(query_devices=lambda: [software.device]))
    assert main(["capture", "--out", str(tmp_path / "taken"), "--settle", "2"]) == 0
    frame = ilf.load_frame(tmp_path / "taken")
    assert (frame.shape, frame.intrinsics.fx) == ((H, W), 30)
    assert np.nanmedian(frame.depth) == pytest.approx(np.nanmedian(register(pair).depth), abs=0.01)
    assert main(["capture", "--out", str(tmp_path / "taken"), "--settle", "1"]) == 1


def test_no_camera_is_one_message(library: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["capture", "--out", str(tmp_path / "none")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("ilf: error: No RealSense camera is connected")
    assert said.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_what_the_library_records_is_read(library: Any, tmp_path: Path) -> None:
    """Newer versions of it write ROS 2."""
    software, path = SoftwareDevice(library), tmp_path / "recorded.db3"
    software.device.create_matcher(library.matchers.default)
    try:
        recorder = library.recorder(str(path), software.device)
    except RuntimeError as error:
        pytest.skip(str(error))
    queue = library.frame_queue(20)
    sensors = recorder.query_sensors()
    for sensor in sensors:
        sensor.open(sensor.get_stream_profiles())
        sensor.start(queue)
    for number in range(3):
        software.show(number)
        queue.wait_for_frame(2000)
        queue.wait_for_frame(2000)
    for sensor in sensors:
        sensor.stop()
        sensor.close()
    del sensor, sensors, recorder  # which closes the file
    source = ilf.open_source(path)
    assert len(source) == 3
    assert not source.is_registered
    cameras = source.calibration(source.keys[0])
    assert (cameras.colour.fx, cameras.depth.fx) == (30, 25)
    assert cameras.depth_to_colour[:3, 3] == pytest.approx([0.015, 0, 0], abs=1e-6)
    assert cameras.depth_to_colour[1, 0] == pytest.approx(math.sin(0.004), abs=1e-6)
    pair = source.read(source.keys[2], registered=False)
    assert np.array_equal(pair.rgb, COLOUR + 2)
    assert pair.depth[0, 0] == np.float32(1.502)
    assert pair.inputs.depth_units == 1000


def test_the_librarys_layout_as_it_is_written_here(tmp_path: Path) -> None:
    source = ilf.open_source(write_library_db3(tmp_path))
    assert len(source) == 2
    assert source.calibration(source.keys[0]).depth_to_colour[:3, 3] == pytest.approx(
        -np.array(SHIFTS["colour"]), abs=1e-3
    )
    pair = source.read(source.keys[1], registered=False)
    assert np.array_equal(pair.rgb, COLOUR + 1)
    assert (pair.depth[0, 0], pair.inputs.depth_units) == (1.5, 1000)


def test_without_the_library(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(InputError, match=r"needs the package pyrealsense2, .*ilf-studio\[realsense\]"):
        capture_frame()
