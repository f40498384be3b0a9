"""Frames of recordings of ROS 1 and ROS 2: which belong together, what they are read as, and what is damaged."""

import contextlib
import importlib
import math
import sqlite3
import struct
import sys
import threading
from dataclasses import replace
from itertools import product

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import ilf
from ilf._runtime.long_work import cancelled_by
from ilf.errors import Cancelled, FormatError, InputError, ParameterError
from ilf.sources.opening import close_all
from ilf.sources.ros_messages import read_rvl
from tests.ilf.bags import (
    COLOUR,
    DEPTH,
    EXTRINSICS,
    KINDS,
    START,
    Bag,
    H,
    K,
    W,
    bag,
    compressed_depth,
    in_metres,
    path_of,
    quantised_depth,
    rvl_depth,
    storage_of,
    write_aligned,
)
from tests.ilf.image_files import write_file, write_rgbd

zstd = importlib.import_module("compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd")


@pytest.mark.parametrize("kind", KINDS)
def test_aligned_depth_of_every_kind_of_bag(tmp_path, kind):
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
    assert camera.colour == camera.depth == replace(frame.intrinsics, size=(W, H))
    assert (frame.intrinsics.fx, frame.intrinsics.cx) == (30, 15.5)
    again = ilf.load_frame(**frame.sources)
    assert again.inputs == frame.inputs
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    alone = ilf.open_source(storage_of(tmp_path, kind))  # without the folder that a recording of ROS 2 is
    assert alone.keys == source.keys
    assert alone.read(source.keys[1]).inputs.depth.sha256 == frame.inputs.depth.sha256


def test_depth_goes_with_the_colour_that_is_nearest_by_its_header(tmp_path):
    """The recorder received the depth late, and one colour has no depth."""
    with bag(tmp_path, "ros1") as out:
        for stamp in (0, 33, 66):
            out.image("/rgb/image_raw", COLOUR, "rgb8", stamp * 10**6)
        for number, stamp in enumerate((5, 60)):
            depth = DEPTH + np.uint16(number) * (DEPTH > 0)
            out.image("/depth_to_rgb/image_raw", depth, "16UC1", stamp * 10**6, received=(stamp + 40) * 10**6)
    source = ilf.open_source(tmp_path / "recording.bag")
    assert [key.split(".")[1] for key in source.keys] == ["000000000", "066000000"]
    assert source.notes == ("1 colour image left out: there is no depth image within 0.02 s.",)
    assert source.read(source.keys[1]).depth[0, 0] == np.float32(1.501)
    assert len(ilf.open_source(tmp_path / "recording.bag", max_gap=0.0055)) == 1
    with pytest.raises(InputError, match=r"smallest difference is 0\.005 s.*--max-gap"):
        ilf.open_source(tmp_path / "recording.bag", max_gap=0.001)


@pytest.mark.parametrize(
    ("options", "message"),
    [({"dataset": "/depth"}, "a dataset is that of a depth file"), ({"undistort": True}, "do not undistort")],
)
def test_options_that_a_recording_cannot_follow_are_refused(tmp_path, options, message):
    path = write_aligned(tmp_path, "mcap", frames=1)
    with pytest.raises(InputError, match=message):
        ilf.load_frame(path, frame=ilf.open_source(path).keys[0], **options)


def test_a_key_finds_its_frame_without_the_gap_it_was_listed_with(tmp_path):
    with bag(tmp_path, "mcap") as out:
        out.image("/rgb", COLOUR, "rgb8", 0)
        out.image("/depth", DEPTH, "16UC1", 150_000_000)
    path = tmp_path / "recording"
    source = ilf.open_source(path, max_gap=0.3)
    close_all()
    assert ilf.load_frame(path, frame=source.keys[0]).depth[0, 0] == np.float32(1.5)


@pytest.mark.parametrize(
    ("encoding", "to_stored"),
    [
        ("bgr8", lambda rgb: rgb[..., ::-1]),
        ("rgba8", lambda rgb: np.dstack([rgb, rgb[..., 0]])),
        ("bgra8", lambda rgb: np.dstack([rgb[..., ::-1], rgb[..., 0]])),
        ("rgb16", lambda rgb: rgb.astype(np.uint16) * 257),
        ("8UC3", lambda rgb: rgb[..., ::-1]),
    ],
)
def test_colour_in_every_order_and_padded_rows(tmp_path, encoding, to_stored):
    with bag(tmp_path, "sqlite3") as out:
        out.image("/camera/image_color", to_stored(COLOUR), encoding, 0, padding=5)
        out.image("/camera/depth_registered/image", DEPTH.astype(">u2"), "16UC1", 0)
    source = ilf.open_source(tmp_path / "recording")
    frame = source.read(source.keys[0])
    assert np.array_equal(frame.rgb, COLOUR)
    assert np.array_equal(frame.depth, in_metres(DEPTH), equal_nan=True)


@pytest.mark.parametrize("step", [0, W])
def test_rows_without_padding_are_read_whatever_the_step_says(tmp_path, step):
    with bag(tmp_path, "sqlite3") as out:
        out.image("/camera/image_color", COLOUR, "rgb8", 0)
        image = out.make(
            "sensor_msgs/msg/Image", out.header(0, "colour"), H, W, "16UC1", 0, step, DEPTH.view(np.uint8).ravel()
        )
        out.write("/camera/depth_registered/image", image, 0)
    source = ilf.open_source(tmp_path / "recording")
    assert np.array_equal(source.read(source.keys[0]).depth, in_metres(DEPTH), equal_nan=True)


@pytest.mark.parametrize(
    "encoding", ["uyvy", "yuv422_yuy2", "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"]
)
def test_colour_as_sensors_give_it(tmp_path, encoding):
    """A picture of one colour is the same in each, but for rounding."""
    red, green, blue = 180, 90, 40
    if encoding.startswith("bayer"):
        stored = np.zeros((H, W), np.uint8)
        for place, letter in enumerate(encoding.split("_")[1][:4]):
            stored[place // 2 :: 2, place % 2 :: 2] = {"r": red, "g": green, "b": blue}[letter]
    else:
        luma, u, v = cv2.cvtColor(np.uint8([[[red, green, blue]]]), cv2.COLOR_RGB2YUV)[0, 0].tolist()
        luma = round(16 + luma * 219 / 255)  # video has less than the whole range
        u, v = (round(128 + (value - 128) * scale) for value, scale in ((u, 0.9), (v, 0.7)))
        pair = (u, luma, v, luma) if encoding == "uyvy" else (luma, u, luma, v)
        stored = np.tile(np.uint8(pair), (H, W // 2)).reshape(H, W, 2)
    with bag(tmp_path, "ros1") as out:
        out.image("/rgb", stored, encoding, 0)
        out.image("/depth", DEPTH, "16UC1", 0)
    source = ilf.open_source(tmp_path / "recording.bag")
    middle = source.read(source.keys[0]).rgb[4:-4, 4:-4]
    assert np.abs(middle.astype(int) - (red, green, blue)).max() <= 12


@pytest.mark.parametrize("kind", KINDS)
def test_compressed_images_are_those_that_were_compressed(tmp_path, kind):
    with bag(tmp_path, kind) as out:
        out.compressed("/a/rgb/compressed", cv2.imencode(".png", COLOUR[..., ::-1])[1].tobytes(), "rgb8; png", 0)
        out.compressed("/a/depth/compressedDepth", compressed_depth(DEPTH), "16UC1; compressedDepth png", 0)
        out.compressed("/b/depth/compressedDepth", quantised_depth(DEPTH), "32FC1; compressedDepth png", 0)
        out.compressed("/c/depth/compressed", cv2.imencode(".png", DEPTH)[1].tobytes(), "16UC1; png compressed ", 0)
    source = ilf.open_source(path_of(tmp_path, kind))
    assert "there are also /b/depth/compressedDepth, /c/depth/compressed" in source.notes[0]
    frame = source.read(source.keys[0])
    assert np.array_equal(frame.rgb, COLOUR)
    assert np.array_equal(frame.depth, in_metres(DEPTH), equal_nan=True)
    for topic, close in (("/b/depth/compressedDepth", 2e-3), ("/c/depth/compressed", 0)):
        other = ilf.open_source(path_of(tmp_path, kind), topics=("/a/rgb/compressed", topic))
        depth = other.read(other.keys[0]).depth
        assert np.array_equal(np.isnan(depth), DEPTH == 0)
        assert np.nanmax(np.abs(depth - in_metres(DEPTH))) <= close


def test_one_of_several_cameras_is_chosen_and_named(tmp_path):
    with bag(tmp_path, "ros1") as out:
        for camera, add in (("left", 0), ("right", 5)):
            out.image(f"/{camera}/color/image_raw", COLOUR + np.uint8(add), "rgb8", 0, f"{camera}_colour")
            out.image(f"/{camera}/infra/image_raw", COLOUR[..., 0], "mono8", 0, f"{camera}_infra")
            out.image(f"/{camera}/depth/image_rect_raw", DEPTH, "16UC1", 0, f"{camera}_depth")
        out.image(
            "/right/aligned_depth_to_color/image_raw", DEPTH + np.uint16(7) * (DEPTH > 0), "16UC1", 0, "right_colour"
        )
    path = tmp_path / "recording.bag"
    source = ilf.open_source(path)
    assert source.is_registered
    assert source.notes[0].startswith(
        "Colour of /right/color/image_raw and depth of /right/aligned_depth_to_color/image_raw are read; there are "
        "also /left/depth/image_rect_raw, /right/depth/image_rect_raw, /left/color/image_raw (--topics"
    )
    assert np.array_equal(source.read(source.keys[0]).rgb, COLOUR + 5)
    topics = ("/left/color/image_raw", "/left/depth/image_rect_raw")
    left = ilf.open_source(path, topics=topics)
    assert left.keys == tuple(f"/left/color/image_raw+/left/depth/image_rect_raw/{key}" for key in source.keys)
    assert left.find(source.keys[0]) == left.keys[0]
    assert not left.is_registered
    with pytest.raises(InputError, match="has no images of the topic /middle/color"):
        ilf.open_source(path, topics=("/middle/color", topics[1]))


def test_depth_of_a_camera_of_its_own_is_registered(tmp_path):
    """The depth camera stands 500 mm to the right of the colour camera, by way of a common parent."""
    half = math.sin(math.pi / 4)
    with bag(tmp_path, "sqlite3") as out:
        turned = (0.0, half, 0.0, half)
        out.tf_static(
            ("body", "colour", (1.0, 2.0, 3.0), turned),
            ("body", "depth_link", (1.0, 2.0, 3.0 - 0.5), turned),
            ("depth_link", "depth", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
        )
        out.info("/color/camera_info", distortion=(0.01, 0.0, 0.001, 0.0, 0.0))
        out.info("/depth/camera_info", matrix=(25.0, 0.0, 15.5, 0.0, 25.0, 11.5, 0.0, 0.0, 1.0), distortion=(0.5,) * 5)
        out.image("/color/image_raw", COLOUR, "rgb8", 0, "colour")
        out.image("/depth/image_rect", np.full((H, W), 1.5, np.float32), "32FC1", 0, "depth")
    source = ilf.open_source(tmp_path / "recording")
    assert not source.is_registered
    cameras = source.calibration(source.keys[0])
    assert cameras.colour.distortion == (0.01, 0.0, 0.001, 0.0, 0.0)
    assert (cameras.depth.fx, cameras.depth.distortion) == (25, ())  # of a rectified image
    expected = np.eye(4)
    expected[0, 3] = 0.5
    assert cameras.depth_to_colour == pytest.approx(expected, abs=1e-9)
    pair = source.read_pair(source.keys[0])
    assert pair.depth[3, 3] == 1.5
    frame = source.read(source.keys[0])
    assert frame.shape == (H, W)
    assert np.nanmax(np.abs(frame.depth - 1.5)) == 0
    assert np.isnan(frame.depth[:, 0]).all()
    assert frame.intrinsics.fx != 30  # without its distortion, colour is another image
    assert ilf.load_frame(**frame.sources).intrinsics == frame.intrinsics


@pytest.mark.parametrize("kind", ["ros1", "mcap"])
@pytest.mark.parametrize("way", ["driver", "sent again and again"])
def test_the_transform_between_the_cameras_is_also_found_elsewhere(tmp_path, kind, way):
    """In the topic of RealSense's driver, column by column, or among transforms that are sent again and again."""
    half = math.sqrt(0.5)
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])  # x of depth is y of colour
    with bag(tmp_path, kind) as out:
        if way == "driver":
            extrinsics = out.make(EXTRINSICS, quarter.T.ravel(), np.array([0.015, 0.0, 0.25]))
            out.write("/camera/extrinsics/depth_to_color", extrinsics, 0)
        else:
            out.tf_static(("world", "colour", (5.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), topic="/tf")
            out.tf_static(("colour", "depth", (0.015, 0.0, 0.25), (0.0, 0.0, half, half)), topic="/tf")
        for stream, pixels, encoding in (("color", COLOUR, "rgb8"), ("depth", DEPTH[:, ::2], "16UC1")):
            out.info(f"/camera/{stream}/camera_info", size=pixels.shape[1::-1])
            out.image(f"/camera/{stream}/image_raw", pixels, encoding, 0, stream.replace("color", "colour"))
    source = ilf.open_source(path_of(tmp_path, kind))
    found = source.calibration(source.keys[0]).depth_to_colour
    assert found[:3, :3] == pytest.approx(quarter, abs=1e-9)
    assert found[:3, 3].tolist() == pytest.approx([0.015, 0.0, 0.25])


def test_what_registration_lacks_is_said(tmp_path):
    with bag(tmp_path, "ros1") as out:
        out.info("/color/camera_info")
        out.image("/color/image_raw", COLOUR, "rgb8", 0, "colour")
        out.image("/depth/image_raw", DEPTH, "16UC1", 0, "depth")
    source = ilf.open_source(tmp_path / "recording.bag")
    with pytest.raises(InputError, match="lacks that of the depth camera and the transform between the two"):
        source.read(source.keys[0])


# depth of 8 bits, and of several transports

GREY = np.ascontiguousarray(COLOUR[..., 0])
JPEG, PNG = (cv2.imencode(suffix, GREY)[1].tobytes() for suffix in (".jpg", ".png"))
PACKED = struct.pack("<iff", 0, 2000.0, 10.0)

NOT_DEPTH = {
    "jpeg": ("compressed", JPEG, "16UC1; jpeg compressed "),
    "jpeg of metres": ("compressed", JPEG, "32FC1; jpeg compressed "),
    "jpeg without an encoding": ("compressed", JPEG, "jpeg"),
    "png of 8 bits": ("compressed", PNG, "16UC1; png compressed "),
    "coloured": ("compressed", cv2.imencode(".png", COLOUR)[1].tobytes(), "bgr8; png compressed bgr8"),
    "packed png of 8 bits": ("compressedDepth", PACKED + PNG, "16UC1; compressedDepth png"),
    "packed metres of 8 bits": ("compressedDepth", PACKED + PNG, "32FC1; compressedDepth png"),
    "mono8": ("image_raw", GREY, "mono8"),
    "8UC1": ("image_raw", GREY, "8UC1"),
    "colour map": ("image_raw", COLOUR, "rgb8"),
    "bytes named 16UC1": ("image_raw", GREY, "16UC1"),
    "bytes named 32FC1": ("image_raw", GREY, "32FC1"),
}


@pytest.mark.parametrize("what", NOT_DEPTH)
def test_depth_of_8_bits_is_refused(tmp_path, what):
    transport, data, encoding = NOT_DEPTH[what]
    topic = f"/camera/depth/{transport}"
    with bag(tmp_path, "ros1") as out:
        out.image("/camera/rgb/image_raw", COLOUR, "rgb8", 0)
        (out.compressed if isinstance(data, bytes) else out.image)(topic, data, encoding, 0)
    path = tmp_path / "recording.bag"
    with pytest.raises(
        InputError, match=f"Depth of {topic} .* is not read: this is an 8-bit image.*export the raw 16-bit"
    ):
        ilf.open_source(path)
    asked = ilf.open_source(path, topics=("/camera/rgb/image_raw", topic))
    with pytest.raises(FormatError, match=r"this is an 8-bit image.*export the raw 16-bit"):
        asked.read(asked.keys[0])


def _write_transports(out: Bag, *transports: str) -> None:
    out.image("/rgb/image_raw", COLOUR, "rgb8", 0)
    base = "/depth_registered/image_raw"
    for transport in transports:
        if transport in {"raw", "metres"}:
            is_raw = transport == "raw"
            out.image(base, DEPTH if is_raw else in_metres(DEPTH), "16UC1" if is_raw else "32FC1", 0)
        elif transport == "jpeg":
            out.compressed(f"{base}/compressed", JPEG, "16UC1; jpeg compressed ", 0)
        elif transport == "quantised":
            for stamp in (0, 33_000_000):
                out.compressed(f"{base}/compressedDepth", quantised_depth(DEPTH), "32FC1; compressedDepth png", stamp)
        else:
            data = compressed_depth(DEPTH) if transport == "png" else rvl_depth(DEPTH)
            out.compressed(f"{base}/compressedDepth", data, f"16UC1; compressedDepth {transport}", 0)


REFUSED = "Depth of /depth_registered/image_raw/compressed (16UC1; jpeg compressed ) is not read: this is an 8-bit"


@pytest.mark.parametrize(
    ("transports", "chosen", "said"),
    [
        (["jpeg", "png"], "/compressedDepth", REFUSED),
        (["jpeg", "raw"], "", REFUSED),
        (["raw", "png"], "", "there are also /depth_registered/image_raw/compressedDepth"),
        (["metres", "quantised"], "", "there are also /depth_registered/image_raw/compressedDepth"),
        (["rvl"], "/compressedDepth", ""),
    ],
)
def test_the_lossless_transport_is_read_and_said(tmp_path, transports, chosen, said):
    with bag(tmp_path, "mcap") as out:
        _write_transports(out, *transports)
    source = ilf.open_source(tmp_path / "recording")
    assert np.array_equal(source[0].depth, in_metres(DEPTH), equal_nan=True)
    note = " ".join(source.notes)
    assert said in note
    assert (f"depth of /depth_registered/image_raw{chosen} are read" in note) == bool(said)


def test_other_pictures_are_neither_depth_nor_colour(tmp_path):
    """Infrared of 16 bits, and depth in false colours, which come first by name and by number."""
    with bag(tmp_path, "sqlite3") as out:
        for stamp in (0, 33_000_000):
            out.image("/a/ir/image_raw", DEPTH + np.uint16(1), "mono16", stamp)
            out.image("/a/depth/image_raw/shown", COLOUR[::-1], "rgb8", stamp)
            out.image("/b/depth/image_color", COLOUR[::-1], "rgb8", stamp)
        out.pair(DEPTH, "mono16", ("/b/rgb/image_raw", "/b/depth/image_raw"))
    frame = ilf.open_source(tmp_path / "recording")[0]
    assert np.array_equal(frame.rgb, COLOUR)
    assert np.array_equal(frame.depth, in_metres(DEPTH), equal_nan=True)


@given(data=st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_depth_by_rvl_is_exact_and_damage_is_an_error(data):
    shape = data.draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    values = data.draw(arrays(np.uint16, shape, elements=st.sampled_from([0, 0, 1, 1500, 1501, 65535])))
    packed = np.frombuffer(rvl_depth(values)[12:], np.uint8)
    assert np.array_equal(read_rvl(packed, "image"), values)
    damaged = packed[: data.draw(st.integers(0, len(packed)))].copy()
    if len(damaged) > 8:
        damaged[data.draw(st.integers(8, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(FormatError):
        assert read_rvl(damaged, "image").shape == values.shape


# lenses


PRISM = (0.3338, -0.0391, -7.1e-05, -1.8e-05, -0.0015, 0.6651, -0.0098, -0.0093, 1e-3, 2e-4, -1e-3, 1e-4)


FISHEYE = (0.05, -0.01, 0.004, -0.001)


@pytest.mark.parametrize(
    ("distortion", "registered"),
    [
        *product([PRISM, (*PRISM[:8], 0, 0, 0, 0, 0.02, -0.05), PRISM[:8] + (0.0,) * 6], [True, False]),
        (FISHEYE, False),
    ],
)
def test_lenses_of_12_and_14_coefficients_and_fisheyes(tmp_path, distortion, registered):
    """Registered depth is read as it is; other depth is registered with both lenses undistorted: it shows a plane."""
    with bag(tmp_path, "mcap") as out:
        still = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
        out.tf_static(("colour", "depth", *still))
        for camera in ("color", "depth"):
            model = "equidistant" if distortion is FISHEYE else "rational_polynomial"
            out.info(f"/{camera}/camera_info", distortion=distortion, model=model)
        out.image("/color/image_raw", COLOUR, "rgb8", 0, "colour")
        out.image("/depth/image_raw", np.full((H, W), 1500, np.uint16), "16UC1", 0, "colour" if registered else "depth")
    source = ilf.open_source(tmp_path / "recording")
    assert source.is_registered == registered
    kept = distortion if any(distortion[8:]) else distortion[:8]
    lens = source.calibration(source.keys[0]).colour
    assert (lens.model, lens.distortion) == ("fisheye" if distortion is FISHEYE else "pinhole", pytest.approx(kept))
    frame = source[0]
    assert np.nanmax(np.abs(frame.depth - 1.5)) < 1e-6
    if registered:
        assert frame.intrinsics.fx == 30
        assert any("Undistort the frame on reading" in note for note in frame.notes)
    else:
        assert frame.missing_share < 0.1
        camera, of_model = frame.intrinsics, cv2.fisheye if distortion is FISHEYE else cv2
        ray = np.array([[[(5 - camera.cx) / camera.fx, (7 - camera.cy) / camera.fy, 1.0]]])
        seen, _ = of_model.projectPoints(ray, np.zeros(3), np.zeros(3), np.reshape(K, (3, 3)), np.array(distortion))
        x, y = seen.ravel()
        assert frame.rgb[7, 5, :2] == pytest.approx([8 * x, 10 * y], abs=1.5)  # a ramp along both axes


@pytest.mark.parametrize("stated", [False, True])
def test_registered_images_are_undistorted_as_those_of_files(tmp_path, stated):
    """By the lens of the recording, or by one that is given; the frame is read again as it was."""
    depth = np.full((H, W), 1500, np.uint16)
    depth[5:9, 8:15] = 2400
    lens = {"fx": 30.0, "fy": 30.0, "cx": 15.5, "cy": 11.5, "distortion": [-0.2, 0.05, 0.001, -0.002, 0.0]}
    with bag(tmp_path, "mcap") as out:
        out.info("/color/camera_info", distortion=() if stated else tuple(lens["distortion"]))
        out.pair(depth, topics=("/color/image_raw", "/depth/image_raw"))
    given = {"intrinsics": lens} if stated else {}
    source = ilf.open_source(tmp_path / "recording", undistort=True, **given)
    frame = source[0]
    files = write_rgbd(tmp_path, depth, colour=COLOUR[..., ::-1])
    wanted = ilf.load_frame(*files, intrinsics=lens, undistort=True)
    assert frame.intrinsics.numbers == wanted.intrinsics.numbers != (30.0, 30.0, 15.5, 11.5)
    assert np.array_equal(frame.rgb, wanted.rgb)
    assert np.array_equal(frame.depth, wanted.depth, equal_nan=True)
    assert source.calibration(source.keys[0]).colour.numbers == frame.intrinsics.numbers
    again = ilf.load_frame(**frame.sources)
    assert np.array_equal(again.depth, frame.depth, equal_nan=True)
    assert not any("distortion" in note for note in frame.notes)


@pytest.mark.parametrize("model", ["equidistant", "fisheye", "omni"])
def test_registered_depth_of_a_fisheye_has_no_camera(tmp_path, model):
    with bag(tmp_path, "ros1") as out:
        out.info("/color/camera_info", distortion=(0.1, 0.1, 0.1, 0.1), model=model)
        out.image("/color/image_raw", COLOUR, "rgb8", 0)
        out.image("/depth/image_raw", DEPTH, "16UC1", 0, "depth" if model == "omni" else "colour")
    if model == "omni":
        with pytest.raises(InputError, match="'omni' is not supported"):
            ilf.open_source(tmp_path / "recording.bag")
        return
    frame = ilf.open_source(tmp_path / "recording.bag")[0]
    assert frame.intrinsics is None
    assert any(model in note for note in frame.notes)


# compressed recordings


@pytest.mark.parametrize("kind", ["sqlite3", "mcap"])
@pytest.mark.parametrize("mode", ["FILE", "MESSAGE"])
def test_bags_compressed_by_file_or_message(tmp_path, kind, mode):
    with bag(tmp_path, kind, compression=mode) as out:
        out.pair()
    source = ilf.open_source(tmp_path / "recording")
    assert np.array_equal(source[0].depth, in_metres(DEPTH), equal_nan=True)
    assert any("zstd -d" in note for note in source.notes) == (mode == "FILE")
    (file,) = (tmp_path / "recording").glob("recording.*")
    with pytest.raises(InputError, match="compressed"):
        ilf.open_source(file)
    if mode == "FILE":
        close_all()
        file.write_bytes(file.read_bytes()[:-20])
        with pytest.raises(FormatError, match="recording is damaged"):
            ilf.open_source(tmp_path / "recording")


def test_a_bag_that_would_unpack_without_end_is_refused(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "bag_0.db3.zstd").write_bytes(zstd.compress(bytes(2**26 + 1)))
    with pytest.raises(FormatError, match="200 times as large when unpacked"):
        ilf.open_source(tmp_path / "bag")


# what cannot be read


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("damage", ["cut in half", "cut at its head", "another format"])
def test_a_damaged_recording_is_one_clear_message(tmp_path, kind, damage):
    write_aligned(tmp_path, kind, frames=2)
    path = storage_of(tmp_path, kind)
    content = path.read_bytes()
    cut = {"cut in half": content[: len(content) // 2], "cut at its head": content[:40]}
    path.write_bytes(cut.get(damage, b"\x89PNG\r\n\x1a\n" + bytes(5000)))
    with pytest.raises(InputError, match=str(path)):
        ilf.open_source(path)[0]


def test_messages_that_are_defined_in_another_way(tmp_path):
    write_aligned(tmp_path, "mcap", frames=1)
    path = storage_of(tmp_path, "mcap")
    content = path.read_bytes()
    for ours, other in ((b"string encoding", b"string Encoding"), (b"uint32 step", b"uint16 step")):
        assert ours in content
        path.write_bytes(content.replace(ours, other))
        with pytest.raises(FormatError, match=str(path)):
            ilf.open_source(path)[0]


def test_mcap_without_messages_of_ros_is_not_called_damaged(tmp_path):
    """Its profile is of the header; Foxglove's own schemas have none."""
    write_aligned(tmp_path, "mcap", frames=1)
    path = storage_of(tmp_path, "mcap")
    path.write_bytes(path.read_bytes().replace(b"\4\0\0\0ros2", b"\4\0\0\0json", 1))
    with pytest.raises(FormatError, match="no messages of ROS 2") as error:
        ilf.open_source(path)
    assert "damaged" not in str(error.value)


@pytest.mark.parametrize(
    ("ours", "other"), [("name: /camera/color/image_raw", "name:"), ("message_count: 1", "message_count: many")]
)
def test_topics_that_cannot_be_are_told_of(tmp_path, ours, other):
    path = write_aligned(tmp_path, "sqlite3", frames=1)
    text = (path / "metadata.yaml").read_text()
    assert ours in text
    (path / "metadata.yaml").write_text(text.replace(ours, other))
    with pytest.raises(FormatError, match=f"{path} is damaged"):
        ilf.open_source(path)


def test_a_recording_that_would_be_read_without_end_is_refused(tmp_path, monkeypatch):
    write_aligned(tmp_path, "sqlite3", frames=1)
    path = storage_of(tmp_path, "sqlite3")
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n)"
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("DROP TABLE schema")
        database.execute(f"CREATE VIEW schema AS {endless} SELECT max(i) AS schema_version FROM n")
    monkeypatch.setattr("ilf.sources.recording_in_child.SECONDS", 3.0)
    with pytest.raises(FormatError, match=f"{path} is damaged: reading it takes longer than 3"):
        ilf.open_source(path)
    assert len(ilf.open_source(write_aligned(tmp_path, "ros1", frames=1))) == 1


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits memory")
def test_a_small_recording_does_not_take_gigabytes(tmp_path):
    write_aligned(tmp_path, "sqlite3")
    path = storage_of(tmp_path, "sqlite3")
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
        database.execute("ALTER TABLE topics ADD COLUMN type_description_hash AS (zeroblob(900000000))")
    with pytest.raises(FormatError, match="out of memory"):
        ilf.open_source(path)


def test_a_frame_is_read_to_its_end_by_work_that_is_cancelled(tmp_path):
    """Or else the recording would have to be opened again for the next frame."""
    source = ilf.open_source(write_aligned(tmp_path, "ros1", frames=1))
    cancel_event = threading.Event()
    cancel_event.set()
    with cancelled_by(cancel_event):
        assert source.read(source.keys[0]).shape == (H, W)
        with pytest.raises(Cancelled):
            ilf.open_source(source.path)


def test_a_recording_that_was_not_ended_is_told_how_to_mend_it(tmp_path):
    path = write_aligned(tmp_path, "sqlite3", frames=1)
    (path / "metadata.yaml").unlink()
    with pytest.raises(InputError, match="ros2 bag reindex"):
        ilf.open_source(path)
    bag = write_aligned(tmp_path, "ros1", frames=1)
    content = bag.read_bytes()
    start = content.index(b"index_pos=") + len(b"index_pos=")
    bag.write_bytes(content[:start] + bytes(8) + content[start + 8 :])
    with pytest.raises(FormatError, match="rosbag reindex"):
        ilf.open_source(bag)


def test_a_folder_of_frames_with_a_recording_in_it_is_one_of_frames(tmp_path):
    write_aligned(tmp_path, "mcap", frames=1)
    storage_of(tmp_path, "mcap").rename(tmp_path / "stray.mcap")
    write_file(tmp_path / "rgb/1.png", COLOUR)
    write_file(tmp_path / "depth/1.png", DEPTH)
    assert ilf.open_source(tmp_path).keys == ("rgb/1",)


def test_images_that_say_what_is_not_so(tmp_path):
    with bag(tmp_path, "ros1") as out:
        out.pair()
        out.image("/strange/depth", DEPTH, "32FC1", 0)
        out.image("/strange/rgb", COLOUR, "nv21", 0)
        out.compressed("/cut/depth/compressedDepth", b"1234567890123456", "16UC1; compressedDepth png", 0)
    path = tmp_path / "recording.bag"
    for topics, message in {
        ("/rgb", "/strange/depth"): "do not match",
        ("/depth", "/depth"): "are depth, not colour",
        ("/rgb", "/rgb"): "8-bit image, 3 channels, not depth",
        ("/strange/rgb", "/depth"): "'nv21' are not supported",
    }.items():
        wrong = ilf.open_source(path, topics=topics)
        with pytest.raises(FormatError, match=message):
            wrong.read(wrong.keys[0])


def test_a_key_that_no_frame_has(tmp_path):
    path = write_aligned(tmp_path, "ros1", frames=2)
    with pytest.raises(InputError, match=r"has no frame '7.0'. It has 2, from 1600000000.0"):
        ilf.load_frame(path, frame="7.0")
    with pytest.raises(ParameterError, match="leave the depth file out"):
        ilf.load_frame(path, path, frame="7.0")


def test_a_recording_that_has_changed_is_read_anew(tmp_path):
    path = write_aligned(tmp_path, "ros1", frames=1)
    assert len(ilf.open_source(path)) == 1
    path.unlink()
    write_aligned(tmp_path, "ros1", frames=2)
    assert len(ilf.open_source(path)) == 2
