"""Reading the image files of the Point Cloud Library: organised clouds (PCD), and images compressed by LZF (PCLZF)."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import MAX_FILE_BYTES, FileContent
from .._runtime.memory import check_memory
from ..errors import FormatError, told_as
from .kinds import wrong_kind

PCD_SUFFIX, PCLZF_SUFFIX = ".pcd", ".pclzf"

_MAX_HEADER = 4096
_MAX_FIELDS = 64
_COLOURS = "rgb", "rgba"
_PCLZF_HEADER = struct.Struct("<5s2I16s2I")


def read_pcd_depth(file: FileContent) -> NDArray[np.float32]:
    """Read the coordinate z of an organised cloud as depth (H, W), NaN = missing; its points are in the camera's axes,
    z forward.

    Raises
    ------
    FormatError
        If it is no PCD of version 0.7, not organised, has no z, or is truncated or damaged.
    """
    points = _points(file)
    if "z" not in (points.dtype.names or ()):
        raise FormatError(f"{file} has no field z. Export it with x, y and z.")
    return np.array(points["z"], np.float32)


def read_pcd_colour(file: FileContent) -> NDArray[np.uint8]:
    """Read the colour of an organised cloud, RGB (H, W, 3), from its field rgb or rgba; raises as `read_pcd_depth`."""
    points = _points(file)
    name = next((name for name in _COLOURS if name in (points.dtype.names or ())), None)
    if name is None or points.dtype[name].itemsize != 4:
        raise FormatError(f"{file} has no field rgb of 4 bytes. Export it with colour, or give the colour image.")
    packed = np.ascontiguousarray(points[name]).view(np.uint32)
    return np.stack([(packed >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=-1)


def _points(file: FileContent) -> NDArray[Any]:
    """The points of an organised cloud, a structured array (H, W)."""
    (height, width), fields, kind, start = _header(file)
    if height == 1:
        raise FormatError(f"{file} is not organised: its points have no rows. Save the cloud with width and height.")
    count, data = height * width, file.data[start:].tobytes()
    if kind == "ascii":
        return _of_text(file, data, fields, count).reshape(height, width)
    wanted = count * fields.itemsize
    if kind == "binary_compressed":
        compressed, size = struct.unpack("<2I", data[:8]) if len(data) >= 8 else (0, 0)
        if size != wanted or compressed > len(data) - 8:
            raise _truncated(file)
        return _by_field(lzf_decompressed(file, data[8 : 8 + compressed], size), fields, count).reshape(height, width)
    if len(data) < wanted:
        raise _truncated(file)
    return np.frombuffer(data, fields, count).reshape(height, width)


def _by_field(data: bytes, fields: np.dtype[Any], count: int) -> NDArray[Any]:
    """The points from all values of each field one after the other."""
    points, at = np.empty(count, fields), 0
    for name in fields.names or ():
        points[name] = np.frombuffer(data, fields[name], count, at)
        at += fields[name].itemsize * count
    return points


def _of_text(file: FileContent, data: bytes, fields: np.dtype[Any], count: int) -> NDArray[Any]:
    told = f"{file}: its points cannot be read ({{error}}). Copy or export it again."
    numbers = np.dtype([(name, np.float64, fields[name].shape) for name in fields.names or ()])  # also of integers
    with told_as(FormatError, told, ValueError), np.errstate(invalid="ignore", over="ignore"):
        lines = [line for line in data.decode("ascii").split("\n") if line.partition("#")[0].strip()]
        if len(lines) < count:
            raise ValueError(f"it has {len(lines)} of {count} points")
        return np.loadtxt(lines[:count], numbers, ndmin=1).astype(fields)


def _header(file: FileContent) -> tuple[tuple[int, int], np.dtype[Any], str, int]:
    """The shape (H, W), the fields and the kind of data of a PCD, and the number of bytes of its header."""
    start = file.data[:_MAX_HEADER].tobytes()
    end = re.search(rb"^DATA[ \t]+(\w+)[ \t]*\r?\n", start, re.MULTILINE)
    if end is None or b"FIELDS" not in start[: end.start()]:
        raise wrong_kind(file, start, "a PCD")
    lines = (line.split() for line in start[: end.start()].decode("ascii", "replace").splitlines())
    stated: Mapping[str, list[str]] = {words[0]: words[1:] for words in lines if words and not words[0].startswith("#")}
    told = f"{file}: its header is damaged ({{error}}). Copy or export it again."
    with told_as(FormatError, told, (LookupError, ValueError, TypeError)):
        names = stated["FIELDS"]
        sizes = [int(text) for text in stated["SIZE"]]
        counts = [int(text) for text in stated.get("COUNT", ["1"] * len(names))]
        kinds = [f"<{kind.lower()}{size}" for kind, size in zip(stated["TYPE"], sizes, strict=True)]
        width, height = int(stated["WIDTH"][0]), int(stated["HEIGHT"][0])
        if min(width, height, *counts) < 1 or len(names) > _MAX_FIELDS or max(counts) > _MAX_FIELDS:
            raise ValueError("a size is not positive")
        unique = [name if name not in names[:at] and name != "_" else f"_{at}" for at, name in enumerate(names)]
        shapes = [(count,) if count > 1 else () for count in counts]
        fields = np.dtype([(name, kind, shape) for name, kind, shape in zip(unique, kinds, shapes, strict=True)])
    data = end[1].decode()
    if data not in {"ascii", "binary", "binary_compressed"}:
        raise FormatError(f"{file} contains data of the kind {data!r:.40}: ascii, binary or binary_compressed is read.")
    check_memory(file, width, height)
    if width * height * fields.itemsize > MAX_FILE_BYTES:
        raise FormatError(f"{file}: its points would need more than 1 GiB of memory. Export x, y, z and rgb alone.")
    return (height, width), fields, data, end.end()


# PCLZF: "PCLZF", width, height, the kind of image in 16 characters, sizes before and after decompression, LZF.


def read_pclzf_depth(file: FileContent) -> NDArray[np.uint16]:
    """Read a depth image of PCL's grabbers, (H, W), as stored; raises FormatError if it is anything else."""
    kind, (height, width), data = _pclzf(file)
    if kind != "depth16":
        raise FormatError(f"{file} contains the image {kind!r:.20}, not depth16. Give the file of the depth.")
    return np.frombuffer(data, "<u2").astype(np.uint16).reshape(height, width)


def read_pclzf_colour(file: FileContent) -> NDArray[np.uint8]:
    """Read a colour image of PCL's grabbers, RGB (H, W, 3); raises FormatError if it is anything else."""
    kind, (height, width), data = _pclzf(file)
    if kind != "rgb24":
        raise FormatError(f"{file} contains the image {kind!r:.20}; of colour, rgb24 is read. Export it as PNG.")
    planes = np.frombuffer(data, np.uint8).reshape(3, height, width)
    return np.ascontiguousarray(planes.transpose(1, 2, 0))


_PIXEL_BYTES = {"depth16": 2, "rgb24": 3, "yuv422": 2, "bayer8": 1}


def _pclzf(file: FileContent) -> tuple[str, tuple[int, int], bytes]:
    """The kind of image, its shape, and its bytes."""
    data = file.data.tobytes()
    if len(data) < _PCLZF_HEADER.size or not data.startswith(b"PCLZF"):
        raise wrong_kind(file, data, "a PCLZF")
    _, width, height, name, compressed, size = _PCLZF_HEADER.unpack_from(data)
    kind = name.decode("ascii", "replace").rstrip(" \0")
    if min(width, height) < 1 or size != width * height * _PIXEL_BYTES.get(kind, 0):
        raise FormatError(f"{file}: its header is damaged: {width} x {height} pixels of {kind!r:.20} in {size} bytes.")
    check_memory(file, width, height)
    if compressed != len(data) - _PCLZF_HEADER.size:
        raise _truncated(file)
    return kind, (height, width), lzf_decompressed(file, data[_PCLZF_HEADER.size :], size)


def lzf_decompressed(file: object, data: bytes, size: int) -> bytes:
    """Decompress LZF.

    Parameters
    ----------
    file : object
        For messages.
    data : bytes
    size : int
        Number of bytes after decompression.

    Raises
    ------
    FormatError
        If the data are damaged or do not have that size.

    Examples
    --------
    >>> lzf_decompressed("file", b"\\x00a\\xe0\\x00\\x00", 10)
    b'aaaaaaaaaa'
    """
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end and len(out) <= size:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += data[at]
                at += 1
            start = len(out) - ((control & 31) << 8) - data[at] - 1
            at += 1
            if start < 0:
                break
            length += 2
            if start + length <= len(out):
                out += out[start : start + length]
            else:  # the copy overlaps itself
                period = bytes(out[start:])
                out += (period * (length // len(period) + 1))[:length]
    except IndexError:
        pass
    if len(out) != size:
        raise FormatError(f"{file} is damaged: its compressed data have {len(out)} of {size} bytes. Copy it again.")
    return bytes(out)


def _truncated(file: FileContent) -> FormatError:
    return FormatError(f"{file} is truncated or damaged. Copy or export it again.")
