"""Recordings of an Azure Kinect: a real one, and written ones in every colour format; calibrations by mode; damage."""

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest

import ilf
from ilf.errors import FormatError, InputError
from ilf.sources.azure_kinect import cameras_of
from tests.ilf.bags import COLOUR
from tests.ilf.matroska import calibration, write_azure

REAL = Path(os.environ.get("ILF_TEST_DATA", "../shared/data")) / "sources" / "pyk4a_recording.mkv"


@pytest.mark.skipif(not REAL.is_file(), reason=f"there is no {REAL} (ILF_TEST_DATA)")
def test_a_real_recording():
    """One capture of a cup before a wall: after registration, its edge is where colour has it."""
    source = ilf.open_source(REAL)
    assert (source.keys, source.timestamps, source.is_registered) == (("0.463945",), (0.463945,), False)
    cameras = source.calibration("0.463945")
    depth = [cameras.depth.fx, cameras.depth.fy, cameras.depth.cx, cameras.depth.cy]
    assert depth == pytest.approx([504.608, 504.733, 332.781, 348.830], abs=1e-3)
    assert len(cameras.colour.distortion) == len(cameras.depth.distortion) == 8
    assert cameras.depth_to_colour[:3, 3] == pytest.approx([-0.03208, -0.00221, 0.00388], abs=1e-5)
    pair = source.read_pair("0.463945")
    assert (pair.rgb.shape, pair.depth.shape) == ((720, 1280, 3), (576, 640))
    assert np.isfinite(pair.depth).mean() == pytest.approx(0.765, abs=0.001)
    frame = source.read("0.463945")
    assert frame.shape == (720, 1280)
    missing = np.isnan(frame.depth)
    assert missing.mean() < 0.45
    # the depth camera lights a hexagon: beyond it lies most of what is missing
    assert not pair.depth_view[0, 0]
    assert pair.depth_view[288, 320]
    assert frame.outside_view.sum() / missing.sum() > 0.7
    row, columns = 420, np.arange(270, 310)
    grey = frame.rgb[row, columns].mean(axis=-1)
    edge = columns[np.argmax(np.abs(np.diff(grey)))]
    assert np.nanmin(frame.depth[row, 270 : edge - 5]) > 0.7
    assert np.nanmax(frame.depth[row, edge + 6 : 310]) < 0.3


@pytest.mark.parametrize("colour", ["MJPG", "NV12", "YUY2", "BGRA"])
def test_every_colour_format(tmp_path, colour):
    source = ilf.open_source(write_azure(tmp_path / "a.mkv", colour=colour))
    assert source.keys == ("0.100000", "0.133000", "0.166000")
    assert source.notes == ()
    for number in (2, 0, 1):  # backwards, too
        pair = source.read_pair(source.keys[number])
        assert pair.depth[-1, -1] == np.float32(1 + number / 1000)
        assert np.isnan(pair.depth[:144]).all()
        picture = cv2.resize(COLOUR, (1280, 720), interpolation=cv2.INTER_LINEAR)
        assert np.abs(pair.rgb.astype(int) - picture).mean() < 3
        assert pair.inputs.frame == source.keys[number]


def test_a_frame_is_registered_and_replayed(tmp_path):
    source = ilf.open_source(write_azure(tmp_path / "a.mkv", frames=2))
    frame = source.read(source.keys[1])
    assert frame.shape == (720, 1280)
    assert np.nanmedian(frame.depth) == pytest.approx(1.001, abs=1e-3)
    assert frame.outside_view is not None
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    assert again.inputs == frame.inputs


@pytest.mark.parametrize(
    ("mode", "size", "focal", "centre"),
    [
        ("NFOV_2X2BINNED", (320, 288), 0.49 * 512, 0.51 * 512 - 96.5),
        ("NFOV_UNBINNED", (640, 576), 0.49 * 1024, 0.51 * 1024 - 192.5),
        ("WFOV_2X2BINNED", (512, 512), 0.49 * 512, 0.51 * 512 - 0.5),
        ("WFOV_UNBINNED", (1024, 1024), 0.49 * 1024, 0.51 * 1024 - 0.5),
        ("NV12_720P", (1280, 720), 0.64 * 960, 0.5 * 960 - 120.5),
        ("MJPG_1080P", (1920, 1080), 0.64 * 1440, 0.5 * 1440 - 180.5),
        ("MJPG_1440P", (2560, 1440), 0.64 * 1920, 0.5 * 1920 - 240.5),
        ("BGRA_1536P", (2048, 1536), 0.64 * 1536, 0.5 * 1536 - 0.5),
        ("MJPG_2160P", (3840, 2160), 0.64 * 2880, 0.5 * 2880 - 360.5),
        ("MJPG_3072P", (4096, 3072), 0.64 * 3072, 0.5 * 3072 - 0.5),
    ],
)
def test_modes_of_both_cameras(mode, size, focal, centre):
    """Across by depth's modes, which crop its image so, and down by those of colour."""
    of_depth = "FOV" in mode
    modes = (mode, "MJPG_1080P") if of_depth else ("NFOV_UNBINNED", mode)
    cameras = cameras_of(json.dumps(calibration()).encode(), *modes)
    camera = cameras.depth if of_depth else cameras.colour
    assert camera.size == size
    assert ((camera.fx, camera.cx) if of_depth else (camera.fy, camera.cy)) == pytest.approx((focal, centre))
    assert cameras.depth.distortion == (0.01, 0.002, 1e-4, 2e-4, 0.003, 0.004, 0.005, 0.006)


def test_calibrations_that_make_no_cameras(tmp_path):
    good = calibration()
    cut = calibration()
    cut["CalibrationInformation"]["Cameras"].pop()
    short = calibration()
    short["CalibrationInformation"]["Cameras"][0]["Intrinsics"]["ModelParameters"].pop()
    centred = calibration()
    centred["CalibrationInformation"]["Cameras"][1]["Intrinsics"]["ModelParameters"][10] = 0.1
    flat = calibration()
    flat["CalibrationInformation"]["Cameras"][0]["Rt"]["Rotation"] = [0] * 9
    contents = [json.dumps(bad).encode() for bad in (cut, short, centred, flat, [], {})]
    for number, content in enumerate([*contents, b"{"]):
        path = write_azure(tmp_path / f"{number}.mkv", frames=1, attached=content)
        with pytest.raises(FormatError, match=str(path)):
            ilf.open_source(path)
    with pytest.raises(FormatError, match="depth mode 'PASSIVE_IR' is unknown"):
        cameras_of(json.dumps(good).encode(), "PASSIVE_IR", "MJPG_720P")


@pytest.mark.parametrize("damage", ["empty", "cut in half", "cut at its head", "noise"])
def test_a_damaged_recording_is_one_clear_message(tmp_path, damage):
    path = write_azure(tmp_path / "a.mkv", frames=2)
    content = path.read_bytes()
    noise = np.random.default_rng(1).integers(0, 256, 5000, np.uint8).tobytes()
    cut = {"empty": b"", "cut in half": content[: len(content) // 2], "cut at its head": content[:300], "noise": noise}
    path.write_bytes(cut[damage])
    with pytest.raises(InputError, match=str(path)):
        ilf.load_frame(path, frame="0.133000")


def test_depth_of_8_bits_is_refused(tmp_path):
    with pytest.raises(FormatError, match=r"8\.mkv: this is an 8-bit image, not depth: export the raw 16-bit"):
        ilf.open_source(write_azure(tmp_path / "8.mkv", depth_pixels="gray"))


def test_other_videos(tmp_path):
    other = write_azure(tmp_path / "other.mkv", frames=1, depth_tag="SOMETHING")
    with pytest.raises(InputError, match="has no depth track of an Azure Kinect or Femto camera"):
        ilf.open_source(other)
    bare = write_azure(tmp_path / "bare.mkv", frames=1, attached=b"")
    with pytest.raises(InputError, match="the recording contains no calibration"):
        ilf.open_source(bare)
    with pytest.raises(ilf.IlfError, match="it has no topics"):
        ilf.open_source(write_azure(tmp_path / "a.mkv", frames=1), topics=("/a", "/b"))
