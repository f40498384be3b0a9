"""Messages of ROS to frames and back, by REP 118: of `rclpy`, of `rosbags`, or any with the same fields."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.camera import Camera
from ..data.frame import RGBDFrame
from ..io.encodings import encoding_of
from ..io.ros_output import encoded_depth, image_fields
from ..sources.ros_messages import colour_of, depth_of

_MESSAGE = Path("message")
"""In place of a recording's path, in errors."""


def frame_of_messages(colour: Any, depth: Any, info: Any = None, name: str = "frame") -> RGBDFrame:
    """Make a frame from messages of registered images.

    Parameters
    ----------
    colour, depth : sensor_msgs/Image or CompressedImage
        Depth is 32FC1 (metres; NaN and infinite = missing) or 16UC1 (millimetres; 0 = missing).
    info : sensor_msgs/CameraInfo, optional
        Camera of the rectified images; one of zeros is unknown.
    name : str
        Name of the frame.

    Raises
    ------
    InputError
        If colour and depth differ in size, or no depth is known.
    FormatError
        For another encoding, or a damaged image.
    """
    values, units = depth_of(depth, _MESSAGE)
    matrix = None if info is None else np.reshape(info.p, (3, 4))
    camera = None
    if matrix is not None and matrix[0, 0] > 0:
        camera = Camera(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])
    return RGBDFrame(colour_of(colour, _MESSAGE), encoding_of(units).metres(values), camera, name)


def depth_fields(depth: NDArray[np.float32], encoding: str = "32FC1") -> dict[str, Any]:
    """Return the fields of a sensor_msgs/Image with depth, except its header.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    encoding : str
        "32FC1" for metres, NaN = missing; "16UC1" for millimetres, 0 = missing, including depth beyond 65.5 m.

    Returns
    -------
    dict
        height, width, encoding, is_bigendian, step, and data as bytes.

    Examples
    --------
    >>> depth = np.array([[1.5, np.nan]], np.float32)
    >>> fields = depth_fields(depth, "16UC1")
    >>> fields["step"], np.frombuffer(fields["data"], "<u2").tolist()
    (4, [1500, 0])
    """
    fields = image_fields(encoded_depth(depth, encoding), encoding)
    return fields | {"data": fields["data"].tobytes()}
