"""Camera poses from files beside the frames."""

from __future__ import annotations

import math
import os
import re
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import read_file
from ..data.frame import RGBDFrame
from ..errors import InputError
from .times import MAX_TIME_GAP_S

Matrix = NDArray[np.float64]

OPENGL_AXES = np.diag([1.0, -1.0, -1.0, 1.0])
"""Transform of points between camera axes y down, z forward and y up, z backward; its own inverse."""

_TRAJECTORY = "groundtruth.txt"
_FOLDERS = "pose", "poses"
_DEPTH_WORD = re.compile(r"[-_.]?depth$", re.IGNORECASE)


def motion_between(before: RGBDFrame, after: RGBDFrame) -> Matrix | None:
    """The transform of points [m] from the camera before to the camera after, (4, 4); None if not known.

    Both frames must have poses, or come from files with poses beside them, see `camera_pose`.
    """
    start, end = (_pose_of(frame) for frame in (before, after))
    return None if start is None or end is None else np.linalg.inv(end) @ start


def _pose_of(frame: RGBDFrame) -> Matrix | None:
    if frame.pose is not None or frame.inputs is None or frame.inputs.frame is not None:
        return frame.pose
    return camera_pose(frame.inputs.depth.path)


def camera_pose(depth: str | Path) -> Matrix | None:
    """The camera pose of a frame: the transform of its points [m] to the world.

    Parameters
    ----------
    depth : path
        The frame's depth file. Its pose is searched in the layouts of the TUM benchmark (`groundtruth.txt` in the
        parent folder, by the time in the file's name), 7-Scenes (`NAME.pose.txt` beside it, or `pose.txt`), and ScanNet
        (`pose/NAME.txt` beside its folder).

    Returns
    -------
    ndarray of float64, shape (4, 4), or None
        x to the right, y down, z forward. None if there is no such file, or it does not contain the pose.
    """
    *single, trajectory = pose_files(depth)
    for place in single:
        if os.path.isfile(place):
            return read_pose(place)
    if not os.path.isfile(trajectory):
        return None
    return pose_at_time(_trajectory(trajectory, os.stat(trajectory).st_mtime_ns), Path(depth).stem)


def pose_files(depth: str | Path) -> tuple[Path, ...]:
    """The files beside a depth file that may contain the pose of its frame; the last one, those of all frames."""
    path = Path(depth)
    name = _DEPTH_WORD.sub("", path.stem)
    return (
        path.with_name(f"{name}.pose.txt".lstrip(".")),
        *(path.parent.parent / folder / f"{name}.txt" for folder in _FOLDERS),
        path.parent.parent / _TRAJECTORY,
    )


def stated_pose(pose: str | tuple[float, ...]) -> Matrix | None:
    """The camera pose of a text file, or of 16 numbers; None if they are no pose."""
    return read_pose(Path(pose)) if isinstance(pose, str) else checked_pose(np.reshape(pose, (4, 4)))


def read_pose(path: Path) -> Matrix | None:
    """The camera pose of a text file with the three or four rows of its matrix, or with its numbers in one line; None
    if it contains anything else."""
    return as_pose(rows_of(path))


def as_pose(numbers: ArrayLike) -> Matrix | None:
    """The camera pose of 12 or 16 numbers, row by row; None if they are no pose."""
    flat = np.asarray(numbers, np.float64).ravel()
    return (
        checked_pose(np.append(flat, (0, 0, 0, 1)[: 16 - flat.size]).reshape(4, 4)) if flat.size in {12, 16} else None
    )


@lru_cache(maxsize=2)
def _trajectory(path: Path, changed: int) -> Matrix:
    """The numbers of a trajectory file, cached by its modification time: it has a line for each frame."""
    return rows_of(path)


def rows_of(path: Path) -> Matrix:
    """The numbers of a text file, a row per line; empty if it contains anything else."""
    try:
        lines = read_file(path).data.tobytes().decode("utf-8").splitlines()
        rows = np.array([line.split() for line in lines if line.strip() and not line.startswith("#")], float)
    except (InputError, ValueError):
        rows = np.empty(0)
    return rows if rows.ndim == 2 else np.empty((0, 0))


def pose_at_time(rows: Matrix, time: str) -> Matrix | None:
    """The pose nearest in time, from a trajectory with rows of time, tx ty tz, qx qy qz qw; None if the text is no
    time, or there is none within `MAX_TIME_GAP_S`."""
    try:
        wanted = float(time)
    except ValueError:
        return None
    rows = rows[np.isfinite(rows).all(axis=1)]
    if rows.shape[1:] != (8,) or not rows.size:
        return None
    row = rows[np.argmin(np.abs(rows[:, 0] - wanted))]
    return posed(row[4:], row[1:4]) if abs(row[0] - wanted) <= MAX_TIME_GAP_S else None


def posed(quaternion: ArrayLike, position: ArrayLike) -> Matrix | None:
    """The camera pose from a quaternion x, y, z, w and a position [m]; None if they are not a valid pose."""
    length = math.hypot(*np.asarray(quaternion, np.float64))
    if not 0 < length < math.inf:
        return None
    return checked_pose(turned_and_moved(np.asarray(quaternion, np.float64) / length, position))


def turned_and_moved(quaternion: Matrix, position: ArrayLike) -> Matrix:
    """The transform, (4, 4), by a quaternion x, y, z, w of length 1 and a translation."""
    x, y, z, w = quaternion
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = position
    return matrix


def checked_pose(pose: Matrix) -> Matrix | None:
    """The pose if it is valid, else None; where tracking was lost, files contain other numbers."""
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        return None
    turn = pose[:3, :3]
    is_turn = np.abs(turn).max() < 2 and np.allclose(turn @ turn.T, np.eye(3), atol=0.01) and np.linalg.det(turn) > 0
    return pose if is_turn and np.allclose(pose[3], (0, 0, 0, 1), atol=1e-6) else None
