"""Writing completed depth, with colour and expected error, frame by frame into an MCAP file of ROS 2."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .._runtime.installation import optional
from ..data.camera import Camera
from ..errors import ExportError, ParameterError, cause, told_as
from .encodings import UINT16_MAX
from .mcap import END

DEPTH_TOPIC, CAMERA_TOPIC = "/depth_completed", "/camera_info"
COLOUR_TOPIC, ERROR_TOPIC = "/image_rect_color", "/expected_error"
TRANSFORM_TOPIC, WORLD = "/tf", "world"
ENCODINGS_OF_ROS = ("32FC1", "16UC1")
_IMAGE, _INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
_TRANSFORMS = "tf2_msgs/msg/TFMessage"


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


class DepthRecorder(AbstractContextManager["DepthRecorder"]):
    """Writes depth into one MCAP file of ROS 2: topics `depth_completed` and `camera_info`, and `image_rect_color`
    (rgb8), `expected_error` (32FC1, metres) and `tf` for frames that have these. The file is readable between any two
    frames: after a crash or on a full disk it contains those before.

    Parameters
    ----------
    path : path-like
        It must not exist.
    encoding : str
        Encoding of depth: "32FC1" for metres, NaN = missing; "16UC1" for millimetres, 0 = missing, including depth
        beyond 65.5 m.
    frame_id : str
        The coordinate frame of the camera.

    Raises
    ------
    ExportError
        If the file exists or cannot be written.
    InputError
        If the packages rosbags and mcap are not installed (extra `sensors`).
    ParameterError
        If the encoding is unknown.
    """

    def __init__(self, path: str | os.PathLike[str], *, encoding: str = "32FC1", frame_id: str = "camera") -> None:
        if encoding not in ENCODINGS_OF_ROS:
            raise ParameterError(f"Depth is written as {' or '.join(ENCODINGS_OF_ROS)}, not as {encoding!r:.40}.")
        typesys, writer = (
            optional(name, "ilf-studio[sensors]", "Writing a recording of ROS 2")
            for name in ("rosbags.typesys", "mcap.writer")
        )
        self.path, self._encoding, self._frame_id = Path(path), encoding, frame_id
        self._store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        self._content = io.BytesIO()
        self._writer = writer.Writer(
            self._content,
            chunk_size=sys.maxsize,
            compression=writer.CompressionType.NONE,
            index_types=writer.IndexType.NONE,
            repeat_channels=False,
            repeat_schemas=False,
            use_statistics=False,
            use_summary_offsets=False,
            enable_crcs=False,
        )
        self._writer.start("ros2", "ilf")
        self._channels: dict[str, int] = {}
        self._end = 0
        if self.path.exists():
            raise ExportError(f"{self.path} already exists. Choose another name.")
        with told_as(ExportError, f"{self.path} could not be written: {{error}}. Choose another place.", OSError):
            self._file = open(self.path, "xb", buffering=0)  # noqa: SIM115 - closed by `close`
        self._finish_moment()

    def write(self, frame: StampedDepth) -> None:
        """Write a frame, wholly or, after an error, not, and no more afterwards; raises ExportError if it cannot be
        written, for example on a full disk."""
        for topic, message in _messages(self._store, frame, self._encoding, self._frame_id):
            kind = message.__msgtype__
            if topic not in self._channels:
                definition, _ = self._store.generate_msgdef(kind, ros_version=2)
                schema = self._writer.register_schema(kind, "ros2msg", definition.encode())
                self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
            data = bytes(self._store.serialize_cdr(message, kind))
            self._writer.add_message(self._channels[topic], frame.stamp, data, frame.stamp)
        self._finish_moment()

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _finish_moment(self) -> None:
        """Write the messages of a frame as a chunk, and the end of the file, which the next chunk replaces."""
        self._writer.flush()
        size = self._content.tell()
        self._writer.finish()
        try:
            self._write_at(self._end, self._content.getvalue())
        except OSError as error:
            self._file.truncate(self._end)
            if self._end:
                self._write_at(self._end, END)  # there is room: it was there before
            self._file.close()
            raise ExportError(f"{self.path} could not be written: {cause(error)}. It has the frames so far.") from error
        self._end += size
        self._content.seek(0)
        self._content.truncate()

    def _write_at(self, place: int, content: bytes) -> None:
        self._file.seek(place)
        left = memoryview(content)
        while left:
            left = left[self._file.write(left) :]


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
        projection[:, :3] = matrix = camera.matrix
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
