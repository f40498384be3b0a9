"""Cameras of ROS messages: CameraInfo and transforms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...camera import camera_from_numbers, fitted
from ...errors import FormatError, InputError
from ...registration import Camera

INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORM, TRANSFORMS = "geometry_msgs/msg/Transform", "tf2_msgs/msg/TFMessage"

_MOST_COEFFICIENTS = 8
_OTHER_LENSES = ("equidistant", "fisheye", "kannala")


def camera_of(info: Any, topic: str, size: tuple[int, int]) -> Camera | None:
    """The camera of images of a topic, of `size` (width, height); None if its CameraInfo says nothing.

    Rectified images (of a topic with "rect" in its name) have no distortion, and the projection's camera matrix.

    Raises
    ------
    FormatError
        If it makes no camera, or its lens is none of those that are supported.
    """
    # ROS 1 has capitals where ROS 2 has small letters
    matrix, distortion, projection = (
        np.asarray(getattr(info, name, getattr(info, name.upper(), ())), float) for name in ("k", "d", "p")
    )
    try:
        is_rectified = "rect" in topic.rsplit("/", 1)[-1] and projection.size == 12 and projection[0] > 0
        if is_rectified:
            matrix = projection.reshape(3, 4)[:, :3].ravel()
        if matrix.size != 9 or not matrix.any():
            return None
        intrinsics = camera_from_numbers(matrix, "")
        if info.width > 0 and info.height > 0:
            intrinsics = fitted(intrinsics, (info.width, info.height), (size[1], size[0]))
        return Camera(intrinsics, size, () if is_rectified else _distortion(distortion, info.distortion_model))
    except InputError as error:
        raise FormatError(f"the calibration of {topic} cannot be used: {error}") from error


def _distortion(values: NDArray[np.float64], model: str) -> tuple[float, ...]:
    if not values.any():
        return ()
    if any(lens in model.lower() for lens in _OTHER_LENSES):
        raise InputError(f"the lens model {model!r:.40} is not supported. Rectify the images first.")
    if values[_MOST_COEFFICIENTS:].any():
        raise InputError(
            f"it has {values.size} coefficients of distortion; at most {_MOST_COEFFICIENTS} are supported."
        )
    return tuple(values[:_MOST_COEFFICIENTS].tolist())


def motion(transform: Any) -> NDArray[np.float64]:
    """A geometry_msgs/Transform as a matrix, float64 (4, 4); raises FormatError if it is none."""
    turn, shift = transform.rotation, transform.translation
    quaternion = np.array([turn.w, turn.x, turn.y, turn.z], float)
    length = np.linalg.norm(quaternion)
    if not np.isfinite(length) or length < 1e-6:
        raise FormatError("a transform between the cameras has no rotation that makes sense.")
    w, x, y, z = quaternion / length
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, 3] = shift.x, shift.y, shift.z
    return matrix


def between(transforms: Iterable[Any], start: str, end: str) -> NDArray[np.float64] | None:
    """What takes points of one coordinate frame to another, (4, 4), by tf messages; None if they do not connect them.

    Parameters
    ----------
    transforms : iterable of geometry_msgs/TransformStamped
        Each has the pose of a child in its parent.
    start, end : str
        Names of the frames.
    """
    ways: dict[str, list[tuple[str, NDArray[Any]]]] = {}
    for stamped in transforms:
        child, parent = (name.strip("/") for name in (stamped.child_frame_id, stamped.header.frame_id))
        up = motion(stamped.transform)
        ways.setdefault(child, []).append((parent, up))
        ways.setdefault(parent, []).append((child, np.linalg.inv(up)))
    reached = {start.strip("/"): np.eye(4)}
    waiting = [*reached]
    while waiting:
        here = waiting.pop()
        for there, step in ways.get(here, ()):
            if there not in reached:
                reached[there] = step @ reached[here]
                waiting.append(there)
    return reached.get(end.strip("/"))
