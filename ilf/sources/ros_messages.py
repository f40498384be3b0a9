"""Decoding ROS messages: images, camera calibrations, transforms."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .._runtime.memory import check_memory
from ..data.camera import Camera, fitted, lens_of, rigid_transform
from ..errors import FormatError, InputError, told_as
from ..io.depth import checked_depth_values, eight_bit_error
from ..io.encodings import default_depth_units
from ..io.images import image_header, read_colour, read_image
from .trajectories import turned_and_moved

IMAGES = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"

_GREY = ("mono8", "8UC1")

_LAYOUTS: dict[str, tuple[type[np.generic], int]] = {
    **dict.fromkeys(("rgb8", "bgr8", "8UC3"), (np.uint8, 3)),
    **dict.fromkeys(("rgba8", "bgra8", "8UC4"), (np.uint8, 4)),
    **dict.fromkeys(_GREY, (np.uint8, 1)),
    **dict.fromkeys(("bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"), (np.uint8, 1)),
    **dict.fromkeys(("yuv422", "uyvy", "UYVY", "yuv422_yuy2", "yuyv", "YUYV"), (np.uint8, 2)),
    **dict.fromkeys(("rgb16", "bgr16"), (np.uint16, 3)),
    **dict.fromkeys(("16UC1", "mono16"), (np.uint16, 1)),
    "32FC1": (np.float32, 1),
}
"""Encoding -> data type and number of channels."""

_DEPTH = ("16UC1", "mono16", "32FC1")
"""Encodings of depth: integers are millimetres, floats metres, as defined by ROS (REP 118)."""

_TO_RED_FIRST = {
    **dict.fromkeys(("bgr8", "8UC3", "bgr16"), cv2.COLOR_BGR2RGB),
    **dict.fromkeys(("bgra8", "8UC4"), cv2.COLOR_BGRA2RGB),
    "rgba8": cv2.COLOR_RGBA2RGB,
    **dict.fromkeys(_GREY, cv2.COLOR_GRAY2RGB),
    **dict.fromkeys(("yuv422", "uyvy", "UYVY"), cv2.COLOR_YUV2RGB_UYVY),
    **dict.fromkeys(("yuv422_yuy2", "yuyv", "YUYV"), cv2.COLOR_YUV2RGB_YUY2),
    # OpenCV names the pattern by its second row
    "bayer_rggb8": cv2.COLOR_BayerBG2RGB,
    "bayer_bggr8": cv2.COLOR_BayerRG2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGR2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGB2RGB,
}

_QUANTISATION = struct.Struct("<iff")
"""Before the data of compressedDepth: kind of compression, and the quantisation parameters of inverse depth."""

_DEPTH_NAME = re.compile("depth(?!_?cam)|disparity")
_COLOUR_NAME = re.compile("colou?r|rgb")
_OTHER_NAME = re.compile("(?<![a-z])(?:ir(?![a-z])|infra|thermal|confidence|amplitude|intensity)")


def says_depth(topic: str) -> bool:
    """Whether a topic's name says that it has depth: of its parts, the last one that says what it has decides.

    Examples
    --------
    >>> says_depth("/camera/aligned_depth_to_color/image_raw"), says_depth("/depth_sensor/rgb/image_raw")
    (True, False)
    """
    for part in reversed(topic.lower().split("/")):
        if _DEPTH_NAME.search(part):
            return True
        if _COLOUR_NAME.search(part) or _OTHER_NAME.search(part):
            return False
    return False


def is_depth(message: Any, topic: str) -> bool:
    """Whether an image message is meant to be depth, by the topic's name or else by its encoding."""
    return says_depth(topic) or (_encoding(message) in _DEPTH and not _OTHER_NAME.search(topic.lower()))


def is_colour(message: Any) -> bool:
    """Whether an image message has colour, and is neither grey nor depth."""
    return _encoding(message) not in {*_DEPTH, *_GREY} and "mono" not in getattr(message, "format", "")


def is_lossless(message: Any) -> bool:
    """Whether depth of an image message is as it was measured: compression quantises metres, and keeps millimetres."""
    return not _is_packed(message) or _encoding(message) != "32FC1"


def image_size(message: Any, path: Path) -> tuple[int, int]:
    """Width and height of an image message; raises FormatError if it is none."""
    if not hasattr(message, "format"):
        return message.width, message.height
    data = _data(message)[_QUANTISATION.size * _is_packed(message) :]
    if _is_rvl(message):
        return rvl_size(data, path)
    header = image_header(path, data.tobytes())
    return header.width, header.height


def colour_of(message: Any, path: Path) -> NDArray[np.uint8]:
    """Colour of an image message, uint8 (h, w, 3), RGB; raises FormatError."""
    if _encoding(message) in _DEPTH:
        raise FormatError(f"{path}: images in {_encoding(message)} are depth, not colour. Swap the two topics.")
    if hasattr(message, "format"):
        return read_colour(FileContent(path, _data(message)))
    image = _pixels(message, path)
    if image.dtype == np.uint16:
        image = ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    way = _TO_RED_FIRST.get(message.encoding)
    return np.ascontiguousarray(image if way is None else cv2.cvtColor(image, way), np.uint8)


def depth_of(message: Any, path: Path) -> tuple[NDArray[Any], float]:
    """Depth of an image message as stored, and its units per metre; raises FormatError."""
    if _is_packed(message):
        values = _packed_depth(message, path)
    elif hasattr(message, "format"):
        values = checked_depth_values(read_image(FileContent(path, _data(message))), path)
        if (values.dtype.kind == "f") != (_encoding(message) == "32FC1"):
            raise FormatError(f"{path}: an image of {values.dtype} in {message.format!r:.60} has no known unit.")
    else:
        values = checked_depth_values(_pixels(message, path), path)
    return values, default_depth_units(values)


def _packed_depth(message: Any, path: Path) -> NDArray[Any]:
    """Depth of a message of compressedDepth."""
    data = _data(message)
    _, scale, shift = _QUANTISATION.unpack_from(data.data)
    data = data[_QUANTISATION.size :]
    values = read_rvl(data, path) if _is_rvl(message) else read_image(FileContent(path, data))
    values = checked_depth_values(values, path)
    if _encoding(message) != "32FC1":
        return values
    with np.errstate(divide="ignore"):
        metres = np.float32(scale) / (values.astype(np.float32) - np.float32(shift))
    return np.where(values > 0, metres, np.float32(np.nan))


def _data(message: Any) -> NDArray[np.uint8]:
    return np.frombuffer(message.data, np.uint8)


def _encoding(message: Any) -> str:
    """The encoding of an image, also before it was compressed."""
    return str(message.format.split(";")[0].strip() if hasattr(message, "format") else message.encoding)


def _is_packed(message: Any) -> bool:
    return "compressedDepth" in getattr(message, "format", "")


def _is_rvl(message: Any) -> bool:
    return _is_packed(message) and "rvl" in message.format.lower()


def _pixels(message: Any, path: Path) -> NDArray[Any]:
    """An uncompressed image: (h, w), or (h, w, channels)."""
    if message.encoding not in _LAYOUTS:
        known = ", ".join(_LAYOUTS)
        raise FormatError(f"{path}: images in {message.encoding!r:.40} are not supported; those in {known} are.")
    kind, channels = _LAYOUTS[message.encoding]
    height, width, step = message.height, message.width, message.step
    check_memory(path, width, height)
    dtype = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    row = width * channels * dtype.itemsize
    if dtype.itemsize > 1 and step == width * channels and len(message.data) == height * step:
        raise eight_bit_error(path, channels)
    if len(message.data) == height * row:  # there is no padding, whatever the step says
        step = row
    if min(width, height) < 1 or step < row or len(message.data) < (height - 1) * step + row:
        sizes = f"{width} x {height} pixels in {message.encoding}, {len(message.data)} bytes and rows of {step} bytes"
        raise FormatError(f"{path} is damaged: the sizes of an image do not match: {sizes}. Copy it again.")
    data = np.zeros(height * step, np.uint8)
    data[: min(len(data), len(message.data))] = message.data[: len(data)]
    rows = np.ascontiguousarray(data.reshape(height, step)[:, :row]).view(dtype)
    image = rows if channels == 1 else rows.reshape(height, width, channels)
    return image.astype(dtype.newbyteorder("="), copy=False)


# Cameras of ROS messages: CameraInfo and transforms.

INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORM, TRANSFORMS = "geometry_msgs/msg/Transform", "tf2_msgs/msg/TFMessage"

_RATIONAL = 8
"""Coefficients of the rational model: those of prisms and tilt, which follow, are often zero and of any number."""


def camera_of(info: Any, topic: str, size: tuple[int, int]) -> Camera | None:
    """The camera of a topic's images with `size` (width, height); None if its CameraInfo is empty.

    Rectified images (of a topic with "rect" in its name) have no distortion, and the projection's camera matrix.

    Raises
    ------
    FormatError
        If the calibration is invalid, or the lens model is not supported.
    """
    # ROS 1 has capitals where ROS 2 has lower-case letters
    matrix, distortion, projection = (
        np.asarray(getattr(info, name, getattr(info, name.upper(), ())), float) for name in ("k", "d", "p")
    )
    with told_as(FormatError, f"the calibration of {topic} cannot be used: {{error}}", InputError):
        is_rectified = "rect" in topic.rsplit("/", 1)[-1] and projection.size == 12 and projection[0] > 0
        if is_rectified:
            matrix = projection.reshape(3, 4)[:, :3].ravel()
        if matrix.size != 9 or not matrix.any():
            return None
        stated = (info.width, info.height) if info.width > 0 and info.height > 0 else size
        facts = {"K": matrix, "width": stated[0], "height": stated[1]}
        if not is_rectified:
            few = distortion if distortion[_RATIONAL:].any() else distortion[:_RATIONAL]
            facts |= {"lens": info.distortion_model, "distortion": few.tolist() if few.any() else []}
        return fitted(lens_of(facts), (size[1], size[0]))


def transform_matrix(transform: Any) -> NDArray[np.float64]:
    """A geometry_msgs/Transform as a matrix, float64 (4, 4); raises FormatError if it is invalid."""
    turn, shift = transform.rotation, transform.translation
    quaternion = np.array([turn.x, turn.y, turn.z, turn.w], float)
    length = np.linalg.norm(quaternion)
    if not np.isfinite(length) or length < 1e-6:
        raise FormatError("a transform between the cameras has no valid rotation.")
    return turned_and_moved(quaternion / length, (shift.x, shift.y, shift.z))


def extrinsics_matrix(message: Any) -> NDArray[np.float64] | None:
    """The matrix, float64 (4, 4), of the Extrinsics of RealSense's driver, whose rotation is column by column; None if
    there is no message."""
    return None if message is None else rigid_transform(np.reshape(message.rotation, (3, 3)).T, message.translation)


def transform_between(transforms: Iterable[Any], start: str, end: str) -> NDArray[np.float64] | None:
    """The transform of points from one coordinate frame to another, (4, 4), from tf messages; None if not connected.

    Parameters
    ----------
    transforms : iterable of geometry_msgs/TransformStamped
        Each contains the pose of a child in its parent.
    start, end : str
        Names of the coordinate frames.
    """
    ways: dict[str, list[tuple[str, NDArray[Any]]]] = {}
    for stamped in transforms:
        child, parent = (name.strip("/") for name in (stamped.child_frame_id, stamped.header.frame_id))
        up = transform_matrix(stamped.transform)
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


# Depth compressed by RVL: Wilson, "Fast lossless depth image compression", 2017.

_SIZE = struct.Struct("<ii")
_MAX_NIBBLES = 12
"""Maximum number of nibbles of a number, 3 bits each."""
_MAX_BYTES = 4
"""Maximum number of bytes for a pixel, of which a difference needs 3."""


def rvl_size(data: NDArray[np.uint8], path: object) -> tuple[int, int]:
    """Width and height, which precede the compressed values; raises FormatError if they are no size."""
    width, height = _SIZE.unpack_from(data.data) if len(data) > _SIZE.size else (0, 0)
    if min(width, height) < 1:
        raise _damaged(path)
    check_memory(path, width, height)
    return width, height


def read_rvl(data: NDArray[np.uint8], path: object) -> NDArray[np.uint16]:
    """Decompress an image, (H, W). It consists of runs, each of so many zeros followed by so many other values, which
    are stored as differences from the value before.

    Parameters
    ----------
    data : ndarray of uint8
        Width, height and compressed values.
    path : object
        Its file, for messages.

    Raises
    ------
    FormatError
        If the data are truncated or damaged.
    """
    width, height = rvl_size(data, path)
    values = np.zeros(width * height, np.int64)
    numbers = _numbers(data[_SIZE.size :][: _MAX_BYTES * (values.size + 1)], path)
    deltas, places = [], []
    pixel = at = 0
    while pixel < values.size:
        zeros, count = numbers[at : at + 2].tolist() if at + 2 <= numbers.size else (values.size, 1)
        pixel, at = pixel + zeros, at + 2
        if pixel + count > values.size or at + count > numbers.size:
            raise _damaged(path)
        places.append(np.arange(pixel, pixel + count))
        deltas.append(numbers[at : at + count])
        pixel, at = pixel + count, at + count
    coded = np.concatenate(deltas)
    known = np.cumsum((coded >> 1) ^ -(coded & 1))  # the sign is the lowest bit
    if known.size and (known.min() < 0 or known.max() > np.iinfo(np.uint16).max):
        raise _damaged(path)
    values[np.concatenate(places)] = known
    return values.reshape(height, width).astype(np.uint16)


def _numbers(data: NDArray[np.uint8], path: object) -> NDArray[np.int64]:
    """The numbers in the data, of 3 bits per nibble, the lowest first; the fourth bit tells that more follow. A word of
    32 bits has its first nibble at the top."""
    words = data[: len(data) // 4 * 4].view("<u4")
    nibbles = ((words[:, None] >> np.arange(28, -1, -4, dtype=np.uint32)) & 15).ravel().astype(np.int64)
    ends = np.flatnonzero(nibbles < 8)
    if not ends.size:
        raise _damaged(path)
    lengths = np.diff(ends, prepend=-1)
    if lengths.max() > _MAX_NIBBLES:
        raise _damaged(path)
    starts = ends - lengths + 1
    place = np.arange(ends[-1] + 1) - np.repeat(starts, lengths)
    return np.add.reduceat((nibbles[: ends[-1] + 1] & 7) << (3 * place), starts)


def _damaged(path: object) -> FormatError:
    return FormatError(f"{path}: an image compressed by RVL is truncated or damaged.")
