"""`DepthRecorder`: one MCAP file, readable after every frame, also when the program is killed or the disk is full."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import ilf
from ilf.io.ros_output import DepthRecorder, StampedDepth
from ilf.sources.opening import close_all
from tests.ilf.bags import COLOUR, DEPTH, write_aligned

METRES = np.where(DEPTH > 0, DEPTH / np.float32(1000), np.nan).astype(np.float32)
CAMERA = ilf.Camera(30.0, 33.0, 15.1, 12.2)
WRITER = """
import resource, sys
from ilf.errors import ExportError
from ilf.io.ros_output import DepthRecorder
from tests.ilf.io.test_recorder import moment
if int(sys.argv[2]):
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)
recorder = DepthRecorder(sys.argv[1])
for number in range(1000):
    try:
        recorder.write(moment(number))
    except ExportError as error:
        sys.exit(str(error))
    print(number + 1, flush=True)
    if not int(sys.argv[2]):
        sys.stdin.readline()
"""


def moment(number: int) -> StampedDepth:
    pose = np.eye(4)
    pose[:3, 3] = number, 2, 3
    return StampedDepth(METRES, CAMERA, (number + 1) * 10**8, COLOUR, METRES / 100, pose)


def child(path: Path, limit: int) -> subprocess.Popen[str]:
    """A process that writes frames: one for each line that it gets, or all up to a limit of the file's size [bytes]."""
    command = [sys.executable, "-c", WRITER, str(path), str(limit)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True)


def depths(path: Path) -> list[np.ndarray]:
    return [frame.depth for frame in ilf.open_source(path)]


def test_the_file_is_readable_after_every_frame(tmp_path):
    path = tmp_path / "out.mcap"
    with DepthRecorder(path) as recorder:
        for number in range(3):
            recorder.write(moment(number))
            found = depths(path)
            assert len(found) == number + 1
            assert np.array_equal(found[-1], METRES, equal_nan=True)
    source = ilf.open_source(path)
    assert source.timestamps == (0.1, 0.2, 0.3)
    assert source.calibration(source.keys[0]).colour.pinhole == CAMERA
    with pytest.raises(ilf.IlfError, match="already exists"):
        DepthRecorder(path)


def test_all_topics_are_written(tmp_path):
    with DepthRecorder(tmp_path / "out.mcap", encoding="16UC1", frame_id="eye") as recorder:
        recorder.write(moment(4))
    with AnyReader([tmp_path / "out.mcap"], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        found = {one.topic: reader.deserialize(raw, one.msgtype) for one, _, raw in reader.messages()}
    assert set(found) == {"/depth_completed", "/camera_info", "/image_rect_color", "/expected_error", "/tf"}
    assert np.array_equal(found["/depth_completed"].data.view(np.uint16).reshape(DEPTH.shape), DEPTH)
    stamped = found["/tf"].transforms[0]
    assert (stamped.header.frame_id, stamped.child_frame_id) == ("world", "eye")
    moved = stamped.transform
    assert (moved.translation.x, moved.translation.y, moved.rotation.w) == (4, 2, 1)


def test_a_killed_program_leaves_all_frames_that_were_written(tmp_path):
    writer = child(tmp_path / "out.mcap", 0)
    assert writer.stdin is not None
    assert writer.stdout is not None
    for number in range(1, 6):
        assert int(writer.stdout.readline()) == number
        writer.stdin.write("\n")
        writer.stdin.flush()
    os.kill(writer.pid, signal.SIGKILL)  # while it writes the sixth
    writer.communicate()
    assert len(depths(tmp_path / "out.mcap")) in {5, 6}


@pytest.mark.parametrize("cut", [6, 9, 40, 51, 3000, -51, -50, -20, -1])
def test_a_file_that_was_cut_while_a_frame_was_written_is_read_up_to_it(tmp_path, cut):
    """As a kill leaves it: the new chunk up to some byte, over the end of the file."""
    path = tmp_path / "out.mcap"
    with DepthRecorder(path) as recorder:
        for number in range(2):
            recorder.write(moment(number))
        before = path.read_bytes()
        recorder.write(moment(2))
    after = path.read_bytes()
    end = len(after) + cut if cut < 0 else len(before) - 50 + cut
    path.write_bytes(after[:end] + before[end:])
    source = ilf.open_source(path)
    assert source.notes[0] == f"{path} has no end: its recording was cut off. It is read up to its last whole record."
    assert len(source) == (3 if -50 <= cut < 0 else 2)
    assert all(np.array_equal(frame.depth, METRES, equal_nan=True) for frame in source)


def test_a_recording_of_another_program_that_was_cut_is_read_too(tmp_path):
    """It has a summary, the end of which is missing; and one without any whole chunk has no images."""
    (path,) = write_aligned(tmp_path, "mcap").glob("*.mcap")
    whole, expected = path.read_bytes(), depths(path)
    close_all()
    path.write_bytes(whole[:-20])
    found = depths(path)
    close_all()
    assert len(found) == 3
    assert all(np.array_equal(one, other, equal_nan=True) for one, other in zip(found, expected, strict=True))
    path.write_bytes(whole[:1000])
    with pytest.raises(ilf.IlfError, match="It has no images"):
        ilf.open_source(path)


def test_a_full_disk_leaves_the_frames_before_and_is_reported(tmp_path):
    writer = child(tmp_path / "out.mcap", 50_000)
    out, error = writer.communicate()
    written = len(out.split())
    assert written >= 3
    assert writer.returncode == 1
    assert "could not be written" in error
    assert "has the frames so far" in error
    assert len(depths(tmp_path / "out.mcap")) == written
