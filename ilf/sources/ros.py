"""Recordings of ROS 1 (.bag) and ROS 2 (a folder, .db3, .mcap), read by rosbags."""

from __future__ import annotations

import re
import struct
import weakref
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import islice, takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import optional
from ..data.camera import FISHEYE, Cameras
from ..errors import FormatError, InputError, told_as
from ..io.mcap import EndedMcap, whole_size
from .copies import unpacked, unpacking_command
from .pairing import MAX_TIME_GAP_S, TimedPairs, stamped
from .recording import RecordedFrame, Recording, RecordingIndex, Topics, sha256_of
from .ros_messages import (
    IMAGES,
    INFO,
    TRANSFORM,
    TRANSFORMS,
    camera_of,
    colour_of,
    depth_of,
    extrinsics_matrix,
    image_size,
    is_colour,
    is_depth,
    is_lossless,
    says_depth,
    transform_between,
    transform_matrix,
)

# Topics specific to recordings of the RealSense library: depth units and extrinsics.
#
# Until 2.58 it wrote bags of ROS 1, whose images have no meaningful coordinate frame; since then .db3 of ROS 2.

_STREAM = re.compile(r"((?:/device_\d+)/sensor_\d+)/[^/]+_\d+(?=/image/data)")


def realsense_stream(topic: str) -> str | None:
    """The stream of an image topic; None if it is from another program.

    Examples
    --------
    >>> realsense_stream("/device_0/sensor_0/Depth_0/image/data")
    '/device_0/sensor_0/Depth_0'
    """
    found = _STREAM.match(topic)
    return None if found is None else found[0]


# Selecting the topics of a ROS recording with colour and depth of one camera.

_ALIGNED = ("aligned_depth", "depth_registered", "depth_to_rgb", "depth_to_color", "depth2color")
"""Parts of the names of topics whose depth is registered to colour."""

_TRANSPORTS = re.compile(r"/(compressed|compressedDepth)$")


@dataclass(frozen=True)
class ImageTopic:
    """A topic with images.

    Attributes
    ----------
    name : str
    is_depth, is_colour : bool
        Both are False for infrared.
    frame_id : str
        The coordinate frame of its camera.
    size : (int, int)
        Width and height of its first image.
    count : int
        Number of messages.
    is_lossless : bool
        Whether depth has the measured values.
    problem : str
        A sentence on why its images, which should be depth, cannot be read; "" if they can.
    """

    name: str
    is_depth: bool
    is_colour: bool
    frame_id: str
    size: tuple[int, int]
    count: int
    is_lossless: bool
    problem: str

    @property
    def base(self) -> str:
        """The topic's name without its transport."""
        return _TRANSPORTS.sub("", self.name)

    @property
    def infos(self) -> tuple[str, ...]:
        """Topics that may contain the calibration of the camera."""
        stream = realsense_stream(self.name)
        beside = f"{self.base.rsplit('/', 1)[0]}/camera_info"
        return (beside,) if stream is None else (beside, f"{stream}/info/camera_info")


CameraTopics = tuple[ImageTopic, ImageTopic]
"""Colour and depth topic of one camera."""


def _is_registered(colour: ImageTopic, depth: ImageTopic) -> bool:
    """Whether depth has the coordinate frame of colour, or an aligned topic name, and has its size."""
    same_frame = bool(depth.frame_id) and depth.frame_id == colour.frame_id
    return depth.size == colour.size and (same_frame or _is_aligned(depth))


def _rank(camera: CameraTopics) -> tuple[object, ...]:
    """Sort key; the best camera has the smallest."""
    colour, depth = camera
    steps = zip(colour.name.split("/"), depth.name.split("/"), strict=False)
    together = len(list(takewhile(lambda step: step[0] == step[1], steps)))
    sent = sum(topic.base != topic.name for topic in camera)
    named = not says_depth(depth.name), "depth" in colour.name.lower()
    apart = not _is_registered(*camera), not _is_aligned(depth), -together
    return *named, *apart, not depth.is_lossless, -min(colour.count, depth.count), sent, colour.name, depth.name


def select_topics(topics: Sequence[ImageTopic], wanted: Topics | None) -> tuple[CameraTopics, str]:
    """Select the camera to read, with a note on the selection; "" if there is no choice.

    Aligned depth is preferred, then cameras whose topics have a long common path.

    Raises
    ------
    InputError
        If there is none, or the wanted topics are missing; the message lists the available ones.
    """
    if wanted is not None:
        known = {topic.name: topic for topic in topics}
        if missing := " and ".join(name for name in wanted if name not in known):
            raise InputError(f"has no images of the topic {missing}. {_topic_list(topics)}")
        return (known[wanted[0]], known[wanted[1]]), ""
    readable = [topic for topic in topics if not topic.problem]
    colours = [topic for topic in readable if topic.is_colour] or [topic for topic in readable if not topic.is_depth]
    cameras = [(colour, depth) for colour in colours for depth in readable if depth.is_depth]
    if not cameras:
        raise InputError(f"has no colour images with depth. {_topic_list(topics)}")
    best = min(cameras, key=_rank)
    others = [name for at in (1, 0) for name in sorted({camera[at].name for camera in cameras} - {best[at].name})]
    problems = [topic.problem for topic in topics if topic.problem]
    if not (others or problems):
        return best, ""
    more = f"; there are also {', '.join(others)} (--topics COLOUR,DEPTH)" if others else ""
    note = f"Colour of {best[0].name} and depth of {best[1].name} are read{more}."
    return best, " ".join([note, *problems])


def _is_aligned(depth: ImageTopic) -> bool:
    return any(word in depth.name for word in _ALIGNED)


def _topic_list(topics: Sequence[ImageTopic]) -> str:
    if not topics:
        return "It has no images."
    names = [topic.name for topic in topics if not topic.problem]
    listed = f"Its image topics are {', '.join(names)}." if names else ""
    return " ".join([listed, *(topic.problem for topic in topics if topic.problem)]).strip()


METADATA = "metadata.yaml"
_STORAGE = (".db3", ".mcap")
_PACKED = tuple(suffix + packed for suffix in _STORAGE for packed in (".zstd", ".zst"))
"""Extensions of the files of `ros2 bag record --compression-mode file`."""
_ZSTD = b"\x28\xb5\x2f\xfd"
"""The first bytes of what zstd has compressed."""
_PICTURES = re.compile("Image|Packet|Video|Cloud")
"""Types of messages that may have depth."""
_MAX_TRANSFORMS = 2000
"""Messages in which a transform is looked for: what does not move is sent again and again."""


def _compressed_bag(path: Path) -> tuple[list[Path], list[Path]]:
    """The plain and the compressed files of a folder in which some were compressed; empty for other recordings. A file
    that was unpacked beside its compressed one counts as plain."""
    inside = sorted(path.iterdir()) if path.is_dir() else []
    packed = [file for file in inside if file.name.lower().endswith(_PACKED)]
    plain = [file for file in inside if packed and file.suffix.lower() in _STORAGE]
    return plain, [file for file in packed if file.with_suffix("") not in plain]


class RosBag(Recording):
    """A recording of ROS. A frame is a colour image with the depth image nearest in time by their header stamps. A key
    is the stamp of the colour, preceded by the names of the topics if these were given."""

    kind = "a ROS bag"
    suffixes = (".bag", *_STORAGE)
    has_topics = True
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        highlevel = optional("rosbags.highlevel", "ilf-studio[sensors]", "A ROS bag")
        typesys = optional("rosbags.typesys", "ilf-studio[sensors]", "A ROS bag")
        plain, self._packed = _compressed_bag(path)
        if path.is_dir() and not (plain or self._packed or (path / METADATA).is_file()):
            raise InputError(f"{path} has no {METADATA}: it was not closed properly. Run: ros2 bag reindex {path}")
        self._temporary = ExitStack()
        weakref.finalize(self, self._temporary.close)
        files = [*plain, *self._temporary.enter_context(unpacked(self._packed))] or [path]
        sizes = [whole_size(file) if file.suffix.lower() == ".mcap" and file.is_file() else None for file in files]
        self._is_cut = any(size is not None for size in sizes)
        opened = [file if size is None else EndedMcap(file, size) for file, size in zip(files, sizes, strict=True)]
        # recordings from before ROS 2 Iron do not contain their message definitions
        known = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        self._reader = highlevel.AnyReader(opened, default_typestore=known)
        try:
            self._reader.open()
        except highlevel.AnyReaderError as error:
            told = f"{path} is not indexed: it was not closed properly. Run: rosbag reindex {path}"
            if "Profile" in str(error):
                told = f"{path} has no messages of ROS 2 (but JSON or protobuf, as Foxglove's). Record topics of ROS 2."
            elif "not indexed" not in str(error):
                raise
            raise FormatError(told) from error
        self._first, self._stamped = cache(self._first_message), cache(self._stamps_of)
        self._pairs, self._known_cameras = cache(self._pairs_of), cache(self._cameras_of)

    @classmethod
    def fits(cls, path: Path) -> bool:
        if not path.is_dir():
            return super().fits(path)
        inside = list(path.iterdir())
        is_ended = any(entry.name == METADATA for entry in inside)
        has_storage = any(entry.name.lower().endswith((*_STORAGE, *_PACKED)) for entry in inside)
        return has_storage and (is_ended or not any(entry.is_dir() for entry in inside))

    def close(self) -> None:
        self._reader.close()
        self._temporary.close()

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        camera, note = self._camera(topics)
        keys, times, left_out = self._pairs(camera).index(max_gap, self.path)
        before = "" if topics is None else f"{'+'.join(topics)}/"
        cut = f"{self.path} has no end: its recording was cut off. It is read up to its last whole record."
        commands = " && ".join(map(unpacking_command, self._packed))
        packed = f"{self.path} is unpacked whenever it is opened. To open it faster, unpack it for good: {commands}"
        said = (cut, self._is_cut), (packed, self._packed), (note, note)
        notes = (*(text for text, is_so in said if is_so), *left_out)
        return tuple(before + key for key in keys), times, notes

    def at(self, key: str) -> tuple[CameraTopics, tuple[int, int]]:
        """The camera of a frame, and the time stamps [ns] of its colour and depth."""
        camera, stamp = self._camera_of(key)
        stamps = self._pairs(camera).find(stamp)
        if stamps is None:
            raise self.unknown(key)
        return camera, stamps

    def frame(self, key: str) -> RecordedFrame:
        (of_colour, of_depth), (colour_stamp, depth_stamp) = self.at(key)
        colour, rgb_sha256 = self._message(of_colour, colour_stamp)
        depth, depth_sha256 = self._message(of_depth, depth_stamp)
        (values, units), rgb = depth_of(depth, self.path), colour_of(colour, self.path)
        units = self._stated_units(of_depth) or units
        return RecordedFrame(rgb, values, rgb_sha256, depth_sha256, units, time=colour_stamp * 1e-9)

    def colour(self, key: str) -> NDArray[np.uint8]:
        (topic, _), (stamp, _) = self.at(key)
        return colour_of(self._message(topic, stamp)[0], self.path)

    def cameras(self, key: str) -> Cameras:
        topics, _ = self.at(key)
        with told_as(FormatError, f"{self.path}: {{error}}", FormatError):
            return self._known_cameras(topics)

    def _cameras_of(self, topics: CameraTopics) -> Cameras:
        colour, depth = topics
        if _is_registered(colour, depth):
            found = self._info(colour) or self._info(depth)
            try:
                camera = None if found is None else camera_of(found, colour.name, colour.size)
                if camera is not None and camera.model == FISHEYE:
                    raise FormatError(f"the lens of {colour.name} is a fisheye ({found.distortion_model}). Rectify it.")
                return Cameras.registered(camera)
            except FormatError as error:  # registered depth needs no camera
                return Cameras.registered(None, f"Intrinsics are not known, since {error}")
        infos = [(self._info(topic), topic) for topic in (colour, depth)]
        cameras = [None if info is None else camera_of(info, topic.name, topic.size) for info, topic in infos]
        return Cameras(cameras[0], cameras[1], self._depth_to_colour(topics))

    def _depth_to_colour(self, camera: CameraTopics) -> NDArray[np.float64] | None:
        found = self._transform("/tf_static", camera)
        for other in (self._realsense_motion, self._extrinsics):
            found = other(camera) if found is None else found
        return self._transform("/tf", camera) if found is None else found  # cameras do not move against each other

    def _transform(self, topic: str, camera: CameraTopics) -> NDArray[np.float64] | None:
        messages = islice(self._messages(topic, TRANSFORMS), _MAX_TRANSFORMS)
        stamped = (one for message in messages for one in message.transforms)
        return transform_between(stamped, camera[1].frame_id, camera[0].frame_id)

    def _extrinsics(self, camera: CameraTopics) -> NDArray[np.float64] | None:
        """The same from the topic of RealSense's driver for ROS."""
        driver = camera[1].base.rsplit("/", 2)[0]
        known = self._reader.typestore.fielddefs  # not in recordings from before ROS 2 Iron
        for one in self._reader.connections:
            if one.topic == f"{driver}/extrinsics/depth_to_color" and one.msgtype in known:
                return extrinsics_matrix(self._first(one.topic)) if "/color/" in camera[0].name else None
        return None

    def _realsense_motion(self, camera: CameraTopics) -> NDArray[np.float64] | None:
        """The same from the RealSense library's own topics, which contain the transforms from a group of streams to
        each of them."""
        streams = [realsense_stream(topic.name) for topic in reversed(camera)]
        for name in sorted({one.topic for one in self._reader.connections if one.msgtype == TRANSFORM}):
            group = name.removeprefix(f"{streams[0]}/tf/")
            if group == name:
                continue
            depth, colour = (self._first(f"{stream}/tf/{group}", TRANSFORM) for stream in streams)
            if depth is not None and colour is not None:  # a topic may have no message
                return transform_matrix(colour) @ np.linalg.inv(transform_matrix(depth))
        return None

    def _stated_units(self, depth: ImageTopic) -> float | None:
        """Units per metre of depth, if the recording is of the RealSense library."""
        found = _STREAM.match(depth.name)
        names = (f"{found[1]}/option/{name}/value" for name in ("Depth Units", "Depth_Units")) if found else ()
        option = next((option for name in names if (option := self._first(name)) is not None), None)
        if option is None:
            return None
        if not 0 < (metres := float(option.data)) < 1:
            raise FormatError(f"{self.path}: its depth units are {metres:g} m, which is not a length.")
        return float(f"{1 / metres:.6g}")  # the option is a float32

    # topics

    def _camera(self, wanted: Topics | None) -> tuple[CameraTopics, str]:
        topics = self._image_topics
        with told_as(InputError, f"{self.path} {{error}}{self._other_depth()}", InputError):
            return select_topics(topics, wanted)

    def _other_depth(self) -> str:
        """A sentence on depth in messages of types that are not read; "" if there is none."""
        others = {
            f"{one.topic} ({one.msgtype})"
            for one in self._reader.connections
            if says_depth(one.topic) and one.msgtype not in IMAGES and _PICTURES.search(one.msgtype)
        }
        return f" Messages of other types are not read: {', '.join(sorted(others))}." if others else ""

    @cached_property
    def _image_topics(self) -> list[ImageTopic]:
        names = sorted({one.topic for one in self._reader.connections if one.msgtype in IMAGES})
        return [topic for name in names if (topic := self._image_topic(name)) is not None]

    def _image_topic(self, name: str) -> ImageTopic | None:
        """An image topic, described by its first image; None if it has none of a known type."""
        first = self._first(name, *IMAGES)
        if first is None:
            return None
        depth, size, problem = is_depth(first, name), (0, 0), ""
        try:
            size = image_size(first, self.path)
            if depth:
                depth_of(first, self.path)
        except FormatError as error:
            if not depth:  # videos have the same message type
                return None
            reason = str(error).removeprefix(f"{self.path}: ")
            problem = f"Depth of {name} ({getattr(first, 'format', '') or first.encoding:.60}) is not read: {reason}"
        # in bags of ROS 1, the RealSense library gives all of its streams the same coordinate frame
        stream = None if self._reader.is2 else realsense_stream(name)
        frame_id = first.header.frame_id.strip("/") if stream is None else stream
        count = sum(one.msgcount for one in self._connections(name, *IMAGES))
        has_colour, is_kept = not depth and is_colour(first), is_lossless(first)
        return ImageTopic(name, depth, has_colour, frame_id, size, count, is_kept, problem)

    def _info(self, topic: ImageTopic) -> Any:
        """The calibration of a topic's camera; None if there is none."""
        return next((info for name in topic.infos if (info := self._first(name, INFO)) is not None), None)

    # frames

    def _camera_of(self, key: str) -> tuple[CameraTopics, str]:
        """The camera that a key names, and the time of its colour."""
        names, _, stamp = key.rpartition("/")
        colour, plus, depth = names.partition("+")
        return self._camera((colour, depth) if plus else None)[0], stamp

    def _pairs_of(self, camera: CameraTopics) -> TimedPairs[int]:
        return TimedPairs(*(stamped(self._stamped(topic), 10**9) for topic in camera))

    def _stamps_of(self, topic: ImageTopic) -> dict[int, int]:
        """Time stamps in the headers [ns] -> times in the recording [ns], by which messages are found; for images
        without a stamp, the latter."""
        known: dict[int, int] = {}
        for _, time, raw in self._raw(self._connections(topic.name, *IMAGES)):
            known.setdefault(self._stamp(raw) or time, time)
        return known

    def _stamp(self, raw: bytes) -> int:
        """The time stamp [ns] in a message's header."""
        is_big = self._reader.is2 and not raw[1] & 1
        seconds, nanoseconds = struct.unpack_from(">II" if is_big else "<II", raw, 4)
        return int(seconds) * 10**9 + int(nanoseconds)

    # messages

    def _message(self, topic: ImageTopic, stamp: int) -> tuple[Any, str]:
        """A topic's message with a time stamp, and the SHA-256 of its bytes."""
        time, connections = self._stamped(topic)[stamp], self._connections(topic.name, *IMAGES)
        for connection, received, raw in self._raw(connections, time, time + 1):
            if stamp in {self._stamp(raw), received}:
                return self._reader.deserialize(raw, connection.msgtype), sha256_of(raw)
        raise FormatError(f"{self.path}: an image of {topic.name} in the index is missing. The recording is damaged.")

    def _first_message(self, name: str, *kinds: str) -> Any:
        """The first message of a topic; None if there is none."""
        return next(self._messages(name, *kinds), None)

    def _messages(self, name: str, *kinds: str) -> Iterator[Any]:
        """All messages of a topic."""
        if connections := self._connections(name, *kinds):
            for connection, _, raw in self._raw(connections):
                yield self._reader.deserialize(raw, connection.msgtype)

    def _raw(self, connections: Sequence[Any], *span: int) -> Iterator[tuple[Any, int, bytes]]:
        """Messages with their connections and times in the recording, of all times or of a span [ns]."""
        for connection, time, raw in self._reader.messages(connections, *span):
            if self._reader.is2 and raw[: len(_ZSTD)] == _ZSTD:
                raise FormatError(f"{self.path}: its messages are compressed: open its folder instead.")
            yield connection, time, raw

    def _connections(self, name: str, *kinds: str) -> list[Any]:
        """The connections of a topic with messages of some types; of any type if none is given."""
        named = (one for one in self._reader.connections if one.topic == name)
        return [one for one in named if not kinds or one.msgtype in kinds]
