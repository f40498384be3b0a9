"""Where the camera was, from files beside the frames."""

from pathlib import Path

import numpy as np
import pytest

import ilf
from ilf.sources.frame_folder import camera_pose
from ilf.sources.trajectories import motion_between, read_trajectory

from ..small_frames import write_small_frame

TURN = np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]], float)
QUARTER = "1 2 3 0 0 0.70710678 0.70710678"
"""The same as a line of a trajectory: a quarter around z."""


def write_matrix(path: Path, pose: np.ndarray = TURN) -> None:
    path.parent.mkdir(exist_ok=True)
    np.savetxt(path, pose)


def test_poses_are_found_where_data_sets_have_them(tmp_path):
    depth = tmp_path / "depth"
    assert camera_pose(depth / "000012.png") is None
    write_matrix(tmp_path / "pose" / "000012.txt")
    assert np.allclose(camera_pose(depth / "000012.png"), TURN)
    write_matrix(depth / "frame-000003.pose.txt")
    assert np.allclose(camera_pose(depth / "frame-000003.depth.png"), TURN)
    (tmp_path / "groundtruth.txt").write_text(f"# time tx ty tz qx qy qz qw\n10.00 0 0 0 0 0 0 1\n10.03 {QUARTER}\n")
    assert np.allclose(camera_pose(depth / "10.025.png"), TURN)
    assert camera_pose(depth / "10.1.png") is None  # nobody knows so long after
    assert camera_pose(depth / "frame-7.png") is None


def test_a_trajectory_of_all_frames_is_by_time_or_in_order(tmp_path):
    path = tmp_path / "poses.txt"
    path.write_text(f"# time tx ty tz qx qy qz qw\n10.00 0 0 0 0 0 0 1\nnan 0 0 0 0 0 0 1\n10.03 {QUARTER}\n")
    assert np.allclose(read_trajectory(path).pose("rgb/10.025.png", 0, 3), TURN)
    np.savetxt(path, [np.eye(4)[:3].ravel(), TURN[:3].ravel()])
    assert np.allclose(read_trajectory(path).pose("rgb/b.png", 1, 2), TURN)


@pytest.mark.parametrize(
    "text", ["", "nothing", "1 2\n3 4\n", "-inf " * 4, "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n", "1e200 0 0 0\n" * 4]
)
def test_what_is_no_pose_is_none(tmp_path, text):
    (tmp_path / "pose").mkdir()
    (tmp_path / "pose" / "1.txt").write_text(text)
    assert camera_pose(tmp_path / "depth" / "1.png") is None
    (tmp_path / "groundtruth.txt").write_text(text)
    assert camera_pose(tmp_path / "depth" / "2.png") is None
    assert camera_pose(tmp_path / "depth" / f"{'2' * 300}.png") is None


def test_motion_between_frames(tmp_path):
    poses = {"unknown": None, "start": np.eye(4), "end": TURN}
    frames = {}
    for name, pose in poses.items():
        (tmp_path / name).mkdir()
        files = write_small_frame(tmp_path / name)
        if pose is not None:
            write_matrix(tmp_path / name / "pose.txt", pose)
        frames[name] = ilf.load_frame(*files)
    assert np.allclose(motion_between(frames["start"], frames["end"]), np.linalg.inv(TURN))
    assert motion_between(frames["start"], frames["unknown"]) is None
    assert motion_between(frames["unknown"], frames["end"]) is None
