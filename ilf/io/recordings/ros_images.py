"""Images of ROS messages -> pixels as they are stored."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ..files import FileContent
from ..images import check_pixel_count, read_colour, read_image

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"

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
"""Encoding -> type and number of its channels."""

_UNITS = {"16UC1": 1000.0, "mono16": 1000.0, "32FC1": 1.0}
"""Encoding of depth -> units per metre, as ROS fixes them (REP 118)."""

_TO_RED_FIRST = {
    **dict.fromkeys(("bgr8", "8UC3", "bgr16"), cv2.COLOR_BGR2RGB),
    **dict.fromkeys(("bgra8", "8UC4"), cv2.COLOR_BGRA2RGB),
    "rgba8": cv2.COLOR_RGBA2RGB,
    **dict.fromkeys(_GREY, cv2.COLOR_GRAY2RGB),
    **dict.fromkeys(("yuv422", "uyvy", "UYVY"), cv2.COLOR_YUV2RGB_UYVY),
    **dict.fromkeys(("yuv422_yuy2", "yuyv", "YUYV"), cv2.COLOR_YUV2RGB_YUY2),
    # the decoder names the pattern by its second row
    "bayer_rggb8": cv2.COLOR_BayerBG2RGB,
    "bayer_bggr8": cv2.COLOR_BayerRG2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGR2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGB2RGB,
}

_DEPTH_HEADER = struct.Struct("<iff")
"""Of compressedDepth: kind of compression, and what inverse depth was quantised with."""


def is_depth(message: Any, topic: str) -> bool:
    """Whether an image message holds depth, by its encoding."""
    if hasattr(message, "format"):
        return "compressedDepth" in message.format + topic or message.format.split(";")[0] in _UNITS
    return message.encoding in _UNITS


def is_colour(message: Any) -> bool:
    """Whether an image message has colours, and is neither grey nor depth."""
    if hasattr(message, "format"):
        return "mono" not in message.format
    return message.encoding not in {*_UNITS, *_GREY}


def colour_of(message: Any, path: Path) -> NDArray[np.uint8]:
    """Colour of an image message, uint8 (h, w, 3), red first; raises FormatError."""
    if hasattr(message, "format"):
        return read_colour(FileContent(path, message.data))
    if message.encoding in _UNITS:
        raise FormatError(
            f"{path}: images in {message.encoding} are depth, and no colour. Name the topics the other way."
        )
    image = _pixels(message, path)
    if image.dtype == np.uint16:
        image = ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)
    way = _TO_RED_FIRST.get(message.encoding)
    return np.ascontiguousarray(image if way is None else cv2.cvtColor(image, way), np.uint8)


def depth_of(message: Any, path: Path) -> tuple[NDArray[Any], float]:
    """Depth of an image message, as it is stored, and its units per metre; raises FormatError."""
    if not hasattr(message, "format"):
        if message.encoding not in _UNITS:
            raise FormatError(f"{path}: images in {message.encoding!r:.40} are no depth; {', '.join(_UNITS)} are.")
        return _pixels(message, path), _UNITS[message.encoding]
    encoding, data = message.format.split(";")[0].strip(), message.data
    if encoding not in _UNITS:
        raise FormatError(f"{path}: compressed depth in {message.format!r:.60} is not supported.")
    if "compressedDepth" not in message.format:
        return _one_channel(read_image(FileContent(path, data)), path), _UNITS[encoding]
    if len(data) <= _DEPTH_HEADER.size:
        raise FormatError(f"{path}: an image of compressed depth is cut off.")
    if "rvl" in message.format.lower():
        raise FormatError(f"{path}: depth compressed by RVL is not supported. Record it as png or as image_raw.")
    _, scale, shift = _DEPTH_HEADER.unpack_from(data)
    values = _one_channel(read_image(FileContent(path, data[_DEPTH_HEADER.size :])), path)
    if encoding != "32FC1":
        return values, _UNITS[encoding]
    with np.errstate(divide="ignore"):
        metres = np.float32(scale) / (values.astype(np.float32) - np.float32(shift))
    return np.where(values > 0, metres, np.float32(np.nan)), 1.0


def _pixels(message: Any, path: Path) -> NDArray[Any]:
    """An uncompressed image: (h, w), or (h, w, channels)."""
    if message.encoding not in _LAYOUTS:
        raise FormatError(
            f"{path}: images in {message.encoding!r:.40} are not supported; those in {', '.join(_LAYOUTS)} are."
        )
    kind, channels = _LAYOUTS[message.encoding]
    height, width, step = message.height, message.width, message.step
    check_pixel_count(path, width, height)
    dtype = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    row = width * channels * dtype.itemsize
    if min(width, height) < 1 or step < row or len(message.data) < (height - 1) * step + row:
        raise FormatError(
            f"{path}: an image of {width} x {height} pixels in {message.encoding} has rows of {step} bytes and "
            f"{len(message.data)} bytes in all, which do not fit. The recording is damaged."
        )
    data = np.zeros(height * step, np.uint8)
    data[: min(len(data), len(message.data))] = message.data[: len(data)]
    rows = np.ascontiguousarray(data.reshape(height, step)[:, :row]).view(dtype)
    image = rows if channels == 1 else rows.reshape(height, width, channels)
    return image.astype(dtype.newbyteorder("="), copy=False)


def _one_channel(image: NDArray[Any], path: Path) -> NDArray[Any]:
    if image.ndim != 2:
        raise FormatError(f"{path}: an image of compressed depth has {image.shape[2]} channels in place of one.")
    return image
