"""Completed depth as a recording of ROS 2: what another program reads of it, and when its frames were taken."""

import shutil

import cv2
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import ilf
from ilf.cli import main
from ilf.data.frame import FrameInputs, InputFile
from ilf.errors import ParameterError
from ilf.io.ros_output import DepthRecorder, StampedDepth
from ilf.run.options import ExportOptions
from ilf.sources.opening import close_all
from ilf.sources.reading import stamp_of
from tests.ilf.bags import COLOUR, DEPTH, START, H, W, write_aligned
from tests.ilf.small_runs import small_run, written

METRES = np.where(DEPTH > 0, DEPTH / 1000, np.nan).astype(np.float32)
RESULTS = ["--results"]
CAMERA = ilf.Camera(30.0, 31.0, 15.5, 11.5)


def _messages(path):
    found = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            assert stamp == time
            found.setdefault(connection.topic, []).append((stamp, message))
    return found


@pytest.mark.parametrize("encoding", ["32FC1", "16UC1"])
def test_depth_and_camera_as_ros_has_them(tmp_path, encoding):
    far = METRES.copy()
    far[0, 0] = 70.0
    beside = ((None, None), (COLOUR, np.where(np.isnan(METRES), np.float32(0.0004), np.float32(np.nan))))
    frames = (
        StampedDepth(depth, CAMERA, START + 5 * number, *beside[number]) for number, depth in enumerate((METRES, far))
    )
    path = tmp_path / "out.mcap"
    with DepthRecorder(path, encoding=encoding, frame_id="lens") as recorder:
        for frame in frames:
            recorder.write(frame)
    found = _messages(path)
    assert [stamp for stamp, _ in found["/depth_completed"]] == [START, START + 5]
    image = found["/depth_completed"][0][1]
    assert (image.height, image.width, image.encoding, image.header.frame_id) == (H, W, encoding, "lens")
    kind, scale, missing = (np.float32, 1.0, np.nan) if encoding == "32FC1" else (np.uint16, 1000.0, 0)
    for (_, message), depth in zip(found["/depth_completed"], (METRES, far), strict=True):
        values = message.data.view(kind).reshape(H, W)
        expected = np.where(np.isnan(depth), missing, depth * np.float32(scale))
        if encoding == "16UC1":
            expected = np.where(expected > 65535, 0, np.rint(expected))
        assert np.array_equal(values, expected.astype(kind), equal_nan=kind is np.float32)
    ((stamp, colour),) = found["/image_rect_color"]
    assert (stamp, colour.encoding, colour.step, colour.header.frame_id) == (START + 5, "rgb8", 3 * W, "lens")
    assert np.array_equal(colour.data.reshape(H, W, 3), COLOUR)
    ((stamp, error),) = found["/expected_error"]
    assert (stamp, error.encoding, error.step, error.header.frame_id) == (START + 5, "32FC1", 4 * W, "lens")
    assert np.array_equal(error.data.view(np.float32).reshape(H, W), beside[1][1], equal_nan=True)
    info = found["/camera_info"][0][1]
    assert (info.width, info.k.tolist()) == (W, [30, 0, 15.5, 0, 31, 11.5, 0, 0, 1])
    with pytest.raises(ParameterError, match="not as '8UC1'"):
        DepthRecorder(tmp_path / "other.mcap", encoding="8UC1")


def test_frames_without_times_follow_each_other_at_the_rate_that_is_given(tmp_path, capsys):
    written(small_run(tmp_path), tmp_path / "runs" / "a", ExportOptions(cloud=None))
    for name in ("b", "c"):
        shutil.copytree(tmp_path / "runs" / "a", tmp_path / "runs" / name)
    assert main(["stream", str(tmp_path / "runs"), *RESULTS, "--out", str(tmp_path / "none.mcap")]) == 1
    assert "has no timestamp. Give the frame rate (--rate)." in capsys.readouterr().err
    assert main(["stream", str(tmp_path / "runs"), *RESULTS, "--out", str(tmp_path / "first.mcap"), "--rate", "4"]) == 0
    found = _messages(tmp_path / "first.mcap")
    assert [stamp for stamp, _ in found["/depth_completed"]] == [0, 250_000_000, 500_000_000]
    words = ["stream", str(tmp_path / "runs"), "--results", "--rate", "4", "--out"]
    for out in (tmp_path / "out.mcap", tmp_path / "frames"):
        assert main([*words, str(out)]) == 0
        frames = list(ilf.open_source(out))
        assert len(frames) == 3
        assert np.array_equal(frames[0].depth, found["/depth_completed"][0][1].data.view("f4").reshape(frames[0].shape))
    close_all()


def test_runs_become_a_recording_with_the_times_of_their_source(tmp_path, capsys, cli):
    labels = np.zeros((H, W), np.uint8)
    labels[2:14, 4:20] = 1
    cv2.imwrite(str(tmp_path / "blocks.png"), labels)
    source = write_aligned(tmp_path, "mcap", frames=2)
    for number, key in enumerate(("1600000000.033000000", "1600000000.000000000")):
        words = ["complete", str(source), "--frame", key, "--blocks", str(tmp_path / "blocks.png")]
        words += [
            "--out",
            str(tmp_path / "runs" / str(number)),
            "--max-iterations",
            "3",
            "--quiet",
            "--depth-formats",
            "npy" if number else "png",
        ]
        assert main([*words, "--no-expected-error"] if number else words) == 0
    close_all()
    assert cli("stream", tmp_path / "runs", *RESULTS, "--out", tmp_path / "out.mcap").out.startswith(
        "2 frames, written to"
    )
    found = _messages(tmp_path / "out.mcap")
    assert [stamp for stamp, _ in found["/depth_completed"]] == [START, START + 33_000_000]
    exact = found["/depth_completed"][0][1].data.view(np.float32).reshape(H, W)
    assert np.array_equal(exact, np.load(tmp_path / "runs" / "1" / "depth.npy"), equal_nan=True)
    written = found["/depth_completed"][1][1].data.view(np.float32).reshape(H, W)
    millimetres = cv2.imread(str(tmp_path / "runs" / "0" / "depth.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(np.rint(1000 * np.nan_to_num(written)), millimetres)
    assert [stamp for stamp, _ in found["/image_rect_color"]] == [START, START + 33_000_000]
    (stamp, message) = found["/expected_error"][0]  # the other run was to have none
    assert (len(found["/expected_error"]), stamp, message.encoding) == (1, START + 33_000_000, "32FC1")
    error = message.data.view(np.float32).reshape(H, W)
    millimetres = cv2.imread(str(tmp_path / "runs" / "0" / "expected_error.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(np.rint(1000 * np.nan_to_num(error)), millimetres)
    assert np.isfinite(error).any()
    assert np.isnan(error).any()
    source_again = ilf.open_source(tmp_path / "out.mcap")
    frame = source_again.read(source_again.keys[1])
    assert np.array_equal(frame.depth, written, equal_nan=True)
    assert np.array_equal(frame.rgb, ilf.open_source(source).read(source_again.keys[1]).rgb)
    assert frame.intrinsics is not None
    close_all()
    cv2.imwrite(str(tmp_path / "runs" / "0" / "expected_error.png"), millimetres[1:])
    assert main(["stream", str(tmp_path / "runs" / "0"), *RESULTS, "--out", str(tmp_path / "odd.mcap")]) == 1
    assert "expected_error.png has another size than its depth" in capsys.readouterr().err
    assert not (tmp_path / "odd.mcap").exists()
    assert "contains no results" in cli("stream", tmp_path, *RESULTS, "--out", tmp_path / "more", status=1).err
    assert (
        ".bag is the file type of ROS 1"
        in cli("stream", tmp_path / "runs", *RESULTS, "--out", tmp_path / "done.bag", status=1).err
    )
    assert not (tmp_path / "done.bag").exists()
    assert "nowhere: cannot be read" in cli("stream", "nowhere", *RESULTS, "--out", "bag", status=1).err


def test_the_time_of_a_frame():
    def of(path, frame=None):
        return stamp_of(FrameInputs(InputFile(path, ""), InputFile(path, ""), 1000.0, None, frame=frame))

    assert of("/a/1305031102.175304.png") == pytest.approx(1305031102175304000, abs=200)
    assert of("/a/000017.png") is None
    assert of("/a.bag", "/rgb+/depth/1600000000.033000001") == 1600000000033000001
    assert of("/a.mkv", "0.463945") == 463945000
