"""Writing completed depth, with colour and expected error, as a ROS 2 bag, or frame by frame into one MCAP file."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .._runtime.installation import optional
from .._runtime.writing import moving_into_place, remove, removed_on_exit
from ..data.camera import Camera
from ..errors import ExportError, ParameterError, told_as
from .depth import UINT16_MAX
from .mcap import McapFile

DEPTH_TOPIC, CAMERA_TOPIC = "/depth_completed", "/camera_info"
COLOUR_TOPIC, ERROR_TOPIC = "/image_rect_color", "/expected_error"
TRANSFORM_TOPIC, WORLD = "/tf", "world"
ENCODINGS_OF_ROS = ("32FC1", "16UC1")
STORAGES = ("mcap", "sqlite3")
_IMAGE, _INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
_TRANSFORMS = "tf2_msgs/msg/TFMessage"
_PURPOSE = "Writing a ROS 2 bag"


@dataclass(frozen=True, eq=False)
class StampedDepth:
    """Depth with a time stamp, and optional colour and expected error.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN = missing.
    intrinsics : Camera or None
        None if they are unknown: the camera is then written as uncalibrated.
    stamp : int
        Time [ns], by the source's clock.
    rgb : ndarray of uint8, shape (H, W, 3), or None
        RGB.
    expected_error : ndarray of float32, shape (H, W), or None
        [m], NaN where depth was measured or is missing.
    pose : ndarray of float64, shape (4, 4), or None
        Transform of the camera's points [m] to the world.
    name : str
        Name of the frame, which a recording does not contain.
    """

    depth: NDArray[np.float32]
    intrinsics: Camera | None
    stamp: int
    rgb: NDArray[np.uint8] | None = None
    expected_error: NDArray[np.float32] | None = None
    pose: NDArray[np.float64] | None = None
    name: str = "frame"


def write_rosbag(
    path: str | os.PathLike[str],
    frames: Iterable[StampedDepth],
    *,
    encoding: str = "32FC1",
    storage: str = "mcap",
    frame_id: str = "camera",
) -> int:
    """Write depth as a ROS 2 bag, frame by frame: topics `depth_completed` and `camera_info`, and `image_rect_color`
    (rgb8), `expected_error` (32FC1, metres) and `tf` for frames that have these.

    Parameters
    ----------
    path : path-like
        Folder of the bag, which must not exist yet.
    frames : iterable of StampedDepth
        In order of time; each is released after it is written.
    encoding : str
        Encoding of depth: "32FC1" for metres, NaN = missing; "16UC1" for millimetres, 0 = missing, including depth
        beyond 65.5 m.
    storage : str
        "mcap" or "sqlite3" (.db3).
    frame_id : str
        The coordinate frame of the camera.

    Returns
    -------
    int
        Number of frames written.

    Raises
    ------
    ExportError
        If `path` already exists, or the bag cannot be written: then no part of it is left.
    InputError
        If the package rosbags is not installed (extra `sensors`).
    ParameterError
        If encoding or storage are unknown.
    """
    if encoding not in ENCODINGS_OF_ROS or storage not in STORAGES:
        raise ParameterError(
            f"Depth must be written as {' or '.join(ENCODINGS_OF_ROS)} into {' or '.join(STORAGES)}, not as "
            f"{encoding!r:.40} into {storage!r:.40}."
        )
    rosbag2 = optional("rosbags.rosbag2", "ilf-studio[sensors]", _PURPOSE)
    target = Path(path).absolute()
    if os.path.lexists(target):
        raise ExportError(f"{target} already exists. Choose another name.")
    # written under its final name, because its files contain the name
    temporary_folder = target.with_name(f".{target.name}-{secrets.token_hex(4)}")
    temporary_bag = temporary_folder / target.name
    plugin = rosbag2.StoragePlugin[storage.upper()]
    with told_as(ExportError, f"{target} could not be written: {{error}}.", OSError):
        temporary_folder.mkdir(parents=True)
        with removed_on_exit(temporary_folder):
            try:
                with rosbag2.Writer(temporary_bag, version=9, storage_plugin=plugin) as writer:
                    count = _write(writer, frames, encoding, frame_id)
                with moving_into_place():
                    os.replace(temporary_bag, target)
            finally:
                remove(temporary_folder)
    return count


def _write(writer: Any, frames: Iterable[StampedDepth], encoding: str, frame_id: str) -> int:
    store = _typestore()
    connections: dict[str, Any] = {}
    count = 0
    for frame in frames:
        for topic, message in _messages(store, frame, encoding, frame_id):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], frame.stamp, store.serialize_cdr(message, kind))
        count += 1
    return count


class DepthRecorder(McapFile):
    """Writes depth into one MCAP file of ROS 2, with the topics of `write_rosbag`. The file is readable between any two
    frames: after a crash or on a full disk it contains those before.

    Parameters
    ----------
    path : path-like
        It must not exist.
    encoding, frame_id : str
        As for `write_rosbag`.

    Raises
    ------
    ExportError
        If the file exists or cannot be written.
    InputError
        If the packages rosbags and mcap are not installed (extra `sensors`).
    """

    def __init__(self, path: str | os.PathLike[str], *, encoding: str = "32FC1", frame_id: str = "camera") -> None:
        self._store, self._encoding, self._frame_id = _typestore(), encoding, frame_id
        super().__init__(path)

    def write(self, frame: StampedDepth) -> None:
        """Write a frame; raises ExportError if it cannot be written, for example on a full disk."""
        for topic, message in _messages(self._store, frame, self._encoding, self._frame_id):
            kind = message.__msgtype__
            definition, _ = self._store.generate_msgdef(kind, ros_version=2)
            self.add(topic, kind, definition, bytes(self._store.serialize_cdr(message, kind)), frame.stamp)
        self.finish_moment()


def _typestore() -> Any:
    typesys = optional("rosbags.typesys", "ilf-studio[sensors]", _PURPOSE)
    return typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)


def _messages(store: Any, frame: StampedDepth, encoding: str, frame_id: str) -> Iterator[tuple[str, Any]]:
    """Yield topics and messages of a frame."""
    time = store.types["builtin_interfaces/msg/Time"](*divmod(frame.stamp, 10**9))
    header = store.types["std_msgs/msg/Header"](stamp=time, frame_id=frame_id)
    yield DEPTH_TOPIC, _image(store, header, encoding, encoded_depth(frame.depth, encoding))
    yield CAMERA_TOPIC, _info(store, header, frame)
    if frame.rgb is not None:
        yield COLOUR_TOPIC, _image(store, header, "rgb8", frame.rgb)
    if frame.expected_error is not None:
        yield ERROR_TOPIC, _image(store, header, "32FC1", encoded_depth(frame.expected_error, "32FC1"))
    if frame.pose is not None:
        yield TRANSFORM_TOPIC, _transforms(store, time, frame_id, frame.pose)


def _transforms(store: Any, time: Any, frame_id: str, pose: NDArray[np.float64]) -> Any:
    """Return the transform of the camera in the world."""
    make = {name: store.types[f"geometry_msgs/msg/{name}"] for name in ("Vector3", "Quaternion", "Transform")}
    turn = Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()
    transform = make["Transform"](make["Vector3"](*pose[:3, 3].tolist()), make["Quaternion"](*turn))
    header = store.types["std_msgs/msg/Header"](stamp=time, frame_id=WORLD)
    stamped = store.types["geometry_msgs/msg/TransformStamped"](header, frame_id, transform)
    return store.types[_TRANSFORMS]([stamped])


def encoded_depth(metres: NDArray[np.float32], encoding: str) -> NDArray[Any]:
    """Return depth [m], NaN = missing, as values of one of the `ENCODINGS_OF_ROS`."""
    if encoding == "32FC1":
        return metres.astype("<f4", copy=False)
    millimetres = np.rint(np.nan_to_num(metres, nan=0.0) * 1000.0)
    return np.where(millimetres <= UINT16_MAX, millimetres, 0).astype("<u2")


def image_fields(values: NDArray[Any], encoding: str) -> dict[str, Any]:
    """The fields of a sensor_msgs/Image with these values, except its header."""
    data = np.ascontiguousarray(values).view(np.uint8).ravel()
    height, width = values.shape[:2]
    sizes = {"height": height, "width": width, "encoding": encoding, "is_bigendian": 0, "step": len(data) // height}
    return {**sizes, "data": data}


def _image(store: Any, header: Any, encoding: str, values: NDArray[Any]) -> Any:
    return store.types[_IMAGE](header=header, **image_fields(values, encoding))


def _info(store: Any, header: Any, frame: StampedDepth) -> Any:
    """Return the camera of registered depth, without distortion; its matrices are zero if it is uncalibrated."""
    camera, matrix, projection = frame.intrinsics, np.zeros((3, 3)), np.zeros((3, 4))
    if camera is not None:
        matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
        projection[:, :3] = matrix
    return store.types[_INFO](
        header=header,
        height=frame.depth.shape[0],
        width=frame.depth.shape[1],
        distortion_model="plumb_bob",
        d=np.zeros(5),
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=projection.ravel(),
        binning_x=0,
        binning_y=0,
        roi=store.types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False),
    )
