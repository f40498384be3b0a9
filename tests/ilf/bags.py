"""Recordings of ROS, written small with the writers of rosbags."""

import itertools
import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

H, W = 24, 32
COLOUR = np.dstack(np.broadcast_arrays(8 * np.arange(W)[None], 10 * np.arange(H)[:, None], 77)).astype(np.uint8)
DEPTH = (1500 + 9 * np.arange(W)[None] + 20 * np.arange(H)[:, None]).astype(np.uint16)
DEPTH[5:9, 10:14] = 0
K = (30.0, 0.0, 16.2, 0.0, 28.0, 10.9, 0.0, 0.0, 1.0)
START = 1_600_000_000 * 10**9
KINDS = ("ros1", "sqlite3", "mcap")

EXTRINSICS = "realsense2_camera_msgs/msg/Extrinsics"
_DEFINITIONS = {EXTRINSICS: "float64[9] rotation\nfloat64[3] translation\n"}
_TRANSFORMS = {"tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"}


class Bag:
    """A recording that is being written. Times are nanoseconds after `START`."""

    def __init__(self, writer: Any, is_ros1: bool) -> None:
        self._writer, self._is_ros1 = writer, is_ros1
        self._store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
        for name, definition in (_DEFINITIONS | (_TRANSFORMS if is_ros1 else {})).items():
            self._store.register(get_types_from_msg(definition, name))
        self._connections: dict[str, Any] = {}
        self._count = 0

    def make(self, name: str, *values: Any, **named: Any) -> Any:
        """A message; of those that ROS 2 has changed, `named` are in ROS 2's words."""
        return self._store.types[name](*values, **named)

    def announce(self, topic: str, message: Any) -> None:
        """A topic of such messages, without one."""
        if topic not in self._connections:
            kind = message.__msgtype__
            self._connections[topic] = self._writer.add_connection(topic, kind, typestore=self._store)

    def write(self, topic: str, message: Any, received: int) -> None:
        kind = message.__msgtype__
        self.announce(topic, message)
        data = self._store.serialize_ros1(message, kind) if self._is_ros1 else self._store.serialize_cdr(message, kind)
        self._writer.write(self._connections[topic], START + received, data)

    def header(self, stamp: int, frame_id: str) -> Any:
        time = self.make("builtin_interfaces/msg/Time", *divmod(START + stamp, 10**9))
        sequence = {"seq": 0} if self._is_ros1 else {}
        return self.make("std_msgs/msg/Header", **sequence, stamp=time, frame_id=frame_id)

    def image(
        self,
        topic: str,
        pixels: np.ndarray,
        encoding: str,
        stamp: int,
        frame_id: str = "colour",
        received: int | None = None,
        padding: int = 0,
    ) -> None:
        rows = np.ascontiguousarray(pixels).reshape(len(pixels), -1).view(np.uint8)
        data = np.pad(rows, ((0, 0), (0, padding)))
        message = self.make(
            "sensor_msgs/msg/Image",
            header=self.header(stamp, frame_id),
            height=pixels.shape[0],
            width=pixels.shape[1],
            encoding=encoding,
            is_bigendian=int(pixels.dtype.byteorder == ">"),
            step=data.shape[1],
            data=data.ravel()[: data.size - padding],  # which need not follow the last row
        )
        self.write(topic, message, stamp if received is None else received)

    def pair(
        self, depth: np.ndarray = DEPTH, encoding: str = "16UC1", topics: Sequence[str] = ("/rgb", "/depth")
    ) -> None:
        """`COLOUR` and depth, at the start."""
        self.image(topics[0], COLOUR, "rgb8", 0)
        self.image(topics[1], depth, encoding, 0)

    def compressed(self, topic: str, data: bytes, what: str, stamp: int, frame_id: str = "colour") -> None:
        message = self.make(
            "sensor_msgs/msg/CompressedImage",
            header=self.header(stamp, frame_id),
            format=what,
            data=np.frombuffer(data, np.uint8),
        )
        self.write(topic, message, stamp)

    def info(
        self,
        topic: str,
        matrix: tuple[float, ...] = K,
        distortion: tuple[float, ...] = (),
        model: str = "plumb_bob",
        size: tuple[int, int] = (W, H),
        stamp: int = 0,
    ) -> None:
        region = self.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        projection = np.zeros((3, 4))
        projection[:, :3] = np.reshape(matrix, (3, 3))
        numbers = {
            "d": np.array(distortion, float),
            "k": np.array(matrix, float),
            "r": np.eye(3).ravel(),
            "p": projection.ravel(),
        }
        if self._is_ros1:
            numbers = {name.upper(): values for name, values in numbers.items()}
        message = self.make(
            "sensor_msgs/msg/CameraInfo",
            header=self.header(stamp, "colour"),
            height=size[1],
            width=size[0],
            distortion_model=model,
            binning_x=0,
            binning_y=0,
            roi=region,
            **numbers,
        )
        self.write(topic, message, stamp)

    def transform(self, shift: tuple[float, float, float], turn: tuple[float, float, float, float]) -> Any:
        """geometry_msgs/Transform; `turn` is x, y, z, w."""
        return self.make(
            "geometry_msgs/msg/Transform",
            self.make("geometry_msgs/msg/Vector3", *shift),
            self.make("geometry_msgs/msg/Quaternion", *turn),
        )

    def tf_static(
        self,
        *poses: tuple[str, str, tuple[float, float, float], tuple[float, float, float, float]],
        topic: str = "/tf_static",
    ) -> None:
        """The poses of children in their parents: (parent, child, shift, turn)."""
        stamped = [
            self.make("geometry_msgs/msg/TransformStamped", self.header(0, parent), child, self.transform(shift, turn))
            for parent, child, shift, turn in poses
        ]
        self.write(topic, self.make("tf2_msgs/msg/TFMessage", stamped), 0)


@contextmanager
def bag(folder: Path, kind: str, name: str = "recording", compression: str = "NONE") -> Iterator[Bag]:
    """Write a recording, with a compression of ROS 1 or a mode of it in ROS 2 (by zstd); `path_of` says where it is."""
    if kind == "ros1":
        writer1 = Writer1(path_of(folder, kind, name))
        if compression != "NONE":
            writer1.set_compression(Writer1.CompressionFormat[compression])
        with writer1:
            yield Bag(writer1, is_ros1=True)
    else:
        plugin = StoragePlugin.SQLITE3 if kind == "sqlite3" else StoragePlugin.MCAP
        writer = Writer2(folder / name, version=9, storage_plugin=plugin)
        writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
        with writer:
            yield Bag(writer, is_ros1=False)


def path_of(folder: Path, kind: str, name: str = "recording") -> Path:
    return folder / (f"{name}.bag" if kind == "ros1" else name)


def storage_of(folder: Path, kind: str, name: str = "recording") -> Path:
    """The file itself, also of ROS 2."""
    if kind == "ros1":
        return path_of(folder, kind, name)
    return folder / name / f"{name}.{'db3' if kind == 'sqlite3' else 'mcap'}"


def compressed_depth(values: np.ndarray) -> bytes:
    """Data of a compressedDepth message of millimetres."""
    return struct.pack("<iff", 0, 0.0, 0.0) + cv2.imencode(".png", values)[1].tobytes()


def quantised_depth(values: np.ndarray) -> bytes:
    """Data of a compressedDepth message of metres: inverse depth, as the plugin quantises it."""
    scale, shift = 2000.0, 10.0
    inverse = np.where(values > 0, np.rint(1000 * scale / np.maximum(values, 1) + shift), 0).astype(np.uint16)
    return struct.pack("<iff", 0, scale, shift) + cv2.imencode(".png", inverse)[1].tobytes()


def in_metres(millimetres: np.ndarray) -> np.ndarray:
    return np.where(millimetres > 0, millimetres / 1000, np.nan).astype(np.float32)


def write_aligned(folder: Path, kind: str, frames: int = 3, name: str = "recording") -> Path:
    """Colour and aligned depth, 30 frames a second, with the depth 4 ms after its colour; returns the path."""
    with bag(folder, kind, name) as out:
        for number in range(frames):
            stamp = number * 33_000_000
            out.info("/camera/color/camera_info", stamp=stamp)
            out.image("/camera/color/image_raw", COLOUR + np.uint8(number), "rgb8", stamp)
            depth = DEPTH + np.uint16(number) * (DEPTH > 0)
            out.image("/camera/aligned_depth_to_color/image_raw", depth, "16UC1", stamp + 4_000_000)
    return path_of(folder, kind, name)


def rvl_depth(values: np.ndarray) -> bytes:
    """Data of a compressedDepth message of millimetres, by RVL."""
    nibbles: list[int] = []

    def put(number: int) -> None:
        while number > 7:
            nibbles.append(number & 7 | 8)
            number >>= 3
        nibbles.append(number)

    before = 0
    for is_known, run in itertools.groupby(values.ravel().tolist(), bool):
        numbers = list(run)
        if is_known and not nibbles:
            put(0)  # it begins with a run of zeros
        put(len(numbers))
        for number in numbers if is_known else ():
            put(2 * (number - before) if number >= before else 2 * (before - number) - 1)
            before = number
    if values.ravel()[-1] == 0:
        put(0)
    nibbles += [0] * (-len(nibbles) % 8)
    words = np.array(nibbles, np.uint32).reshape(-1, 8) @ (16 ** np.arange(7, -1, -1)).astype(np.uint32)
    size = struct.pack("<ii", values.shape[1], values.shape[0])
    return struct.pack("<iff", 0, 0.0, 0.0) + size + words.astype("<u4").tobytes()
