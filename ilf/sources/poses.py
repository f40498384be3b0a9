"""Camera poses: from numbers to checked matrices."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .times import MAX_TIME_GAP_S

Matrix = NDArray[np.float64]

OPENGL_AXES = np.diag([1.0, -1.0, -1.0, 1.0])
"""Transform of points between camera axes y down, z forward and y up, z backward; its own inverse."""


def as_pose(numbers: ArrayLike) -> Matrix | None:
    """The camera pose of 12 or 16 numbers, row by row; None if they are no pose."""
    flat = np.asarray(numbers, np.float64).ravel()
    return (
        checked_pose(np.append(flat, (0, 0, 0, 1)[: 16 - flat.size]).reshape(4, 4)) if flat.size in {12, 16} else None
    )


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
