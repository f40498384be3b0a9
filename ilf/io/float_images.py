"""Reading arrays and images without a common format: NPY, NPZ, EXR, PFM, depth of COLMAP, of a Kinect v2 and of the
RealSense Viewer."""

from __future__ import annotations

import io
import math
import re
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import MAX_FILE_BYTES, FileContent, read_file, zip_member
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from ..errors import FormatError, InputError, told_as
from .kinds import RAW_NUMBERS, kind_of_file, wrong_kind

_MEMORY = 2**31
"""Limit of the memory of a child that reads a file [bytes]."""

# all exceptions of parsing a header as Python text
_NPY_ERRORS = (
    ValueError, TypeError, SyntaxError, ArithmeticError, OSError, EOFError, MemoryError, RecursionError,
    tokenize.TokenError,
)  # fmt: skip


def read_npy(file: FileContent) -> NDArray[Any]:
    """Read the array of an NPY file; raise FormatError if it is damaged or contains Python objects."""
    if file.data[:6].tobytes() != b"\x93NUMPY":
        raise wrong_kind(file, file.data, "an NPY array")
    told = f"{file}: this NPY cannot be read ({{error}}): it is truncated, damaged, or contains Python objects. "
    told += "Save a plain float32 or uint16 array with numpy.save."
    with told_as(FormatError, told, _NPY_ERRORS), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about files written by Python 2
        values = np.asarray(np.lib.format.read_array(io.BytesIO(file.data.data), allow_pickle=False), order="C")
    if values.ndim >= 2:
        check_memory(file, values.shape[1], values.shape[0])
    return values.astype(values.dtype.newbyteorder("="), copy=False)


def is_other_name(name: str) -> bool:
    """Whether the name of an array says that it is no depth, but distance along rays or disparity."""
    return "distance" in name.lower() or "disp" in name.lower()


_NPZ_ERRORS = zipfile.BadZipFile, EOFError, OSError, RuntimeError, ValueError, zlib.error

_SCALE_NAME = re.compile(r"(depth_?)?(map_|image_)?(unit_)?(scale|scaling|(scale_?)?factor|units?)", re.IGNORECASE)


_UNITS = {"mm": 1e3, "millimet": 1e3, "cm": 1e2, "centimet": 1e2, "m": 1.0, "met": 1.0, "0.1mm": 1e4, "100um": 1e4}
"""Units of length in lower case, without spaces and the endings of English -> units per metre."""

_ENDING = re.compile(r"\s+|(er|re)s?$")


def named_scales(items: Iterable[tuple[str, Any]]) -> dict[str, tuple[float, ...]]:
    """The positive numbers, and units of length, of a file, (name, value), that are named as a scale of its depth: name
    with value -> the units per metre that it may mean."""
    found: dict[str, tuple[float, ...]] = {}
    for name, value in items:
        one = np.asarray(value)
        if not _SCALE_NAME.fullmatch(name) or one.size != 1:
            continue
        stated = one.item()
        if one.dtype.kind in "iuf" and 0 < stated < math.inf:
            found[f"{name} {stated:.6g}"] = stated, 1 / stated, 1000 / stated
        text = stated.decode("utf-8", "replace") if isinstance(stated, bytes) else str(stated)
        if (units := _UNITS.get(_ENDING.sub("", text.lower()))) is not None:
            found[f"{name} {text}"] = (units,)
    return found


def npz_scales(file: FileContent) -> dict[str, tuple[float, ...]]:
    """What `named_scales` gives of an NPZ file, which `read_npz` does not apply."""
    told = f"{file}: this NPZ cannot be read ({{error}}). Save it again."
    with told_as(FormatError, told, _NPZ_ERRORS), zipfile.ZipFile(io.BytesIO(file.data.tobytes())) as archive:
        small = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist() if entry.file_size < 1000}
        content = {name: zip_member(archive, small[name], 1000) for name in small if _SCALE_NAME.fullmatch(name)}
    arrays = {name: FileContent(file.path, np.frombuffer(data, np.uint8)) for name, data in content.items()}
    return named_scales((name, read_npy(array)) for name, array in arrays.items())


def read_npz(file: FileContent, names: tuple[str, ...]) -> NDArray[Any]:
    """Read an array of an NPZ file: its only one, unless its name says something else, or the first of these names that
    exists.

    Raises
    ------
    FormatError
        If there are several arrays and none has such a name, or it cannot be read.
    """
    if file.data[:2].tobytes() != b"PK":
        raise wrong_kind(file, file.data, "an NPZ archive of arrays")
    try:
        with zipfile.ZipFile(io.BytesIO(file.data.tobytes())) as archive:
            members = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
            only = next(iter(members)) if len(members) == 1 else ""
            usable = [only] if only and (not is_other_name(only) or "disparity" in names) else names
            name = next((name for name in usable if name in members), None)
            if name is None:
                held = ", ".join(sorted(members)) or "none"
                told = f"{file} has no array named {', '.join(names)}: it has {held:.80}"
                raise FormatError(f"{told}. Save the one to use as {names[0]}.")
            data = np.frombuffer(zip_member(archive, members[name], MAX_FILE_BYTES), np.uint8)
    except _NPZ_ERRORS as error:
        raise FormatError(f"{file}: this NPZ cannot be read ({error!s:.120}). Save it again.") from error
    return read_npy(FileContent(file.path, data))


# Depth from OpenEXR files.

_MAGIC = b"\x76\x2f\x31\x01"
_REMEDY = "Export depth alone, as one channel Z."


def read_exr(file: FileContent) -> NDArray[Any]:
    """Read depth (H, W) from the first part, float16, float32 or uint32, in a child: its channel Z, its only one, the
    only one of red, green and blue that holds more than one value, or three equal ones.

    Raises
    ------
    InputError
        If OpenEXR is not installed.
    FormatError
        If it is not an EXR, is truncated or damaged, has too many pixels, or no depth channel.
    """
    from .._runtime.children import run_in_child

    if file.data[:4].tobytes() != _MAGIC:
        raise wrong_kind(file, file.data, "an EXR")
    return run_in_child(_exr_depth, file, file=str(file), memory=_MEMORY, doing="reading this EXR")


def _exr_depth(file: FileContent) -> NDArray[Any]:
    openexr = optional("OpenEXR", "ilf-studio[sensors]", "Reading EXR")
    stream = io.BytesIO(file.data.tobytes())
    headers = [part.header for part in openexr.File(stream, True, True, 0).parts]
    names = _checked(file, headers)
    stream.seek(0)
    image = openexr.File(stream, True, False, 0)  # omits parts that it cannot read
    if len(image.parts) != len(headers):
        raise ValueError("its pixels cannot be decoded")
    found = [image.channels(0)[name].pixels for name in names]
    found = [values for values in found if values.min() != values.max()] or found[:1]  # Unity: depth in red alone
    if not all(np.array_equal(found[0], other, equal_nan=True) for other in found[1:]):
        raise FormatError(f"{file}: its channels {', '.join(names)} differ: this is colour, not depth. {_REMEDY}")
    return np.ascontiguousarray(found[0])


def encode_exr(depth: NDArray[np.float32]) -> bytes:
    """Return depth (H, W) as EXR, in its channel Z; raises InputError if OpenEXR is not installed."""
    openexr = optional("OpenEXR", "ilf-studio[sensors]", "Writing EXR")
    content = io.BytesIO()
    header = {"compression": openexr.ZIP_COMPRESSION, "type": openexr.scanlineimage}
    openexr.File(header, {"Z": np.ascontiguousarray(depth)}, 0).write(content)
    return content.getvalue()


def _checked(file: FileContent, headers: list[dict[str, Any]]) -> list[str]:
    """Return the depth channels of the first part; raise FormatError if there are none, or too many pixels."""
    for header in headers:
        least, most = np.array(header["dataWindow"], np.int64)
        check_memory(file, *(most - least + 1).tolist())
    first = headers[0]
    if not np.array_equal(first["dataWindow"], first["displayWindow"]):
        raise FormatError(f"{file}: its pixels cover only a part of the image. Export the whole image.")
    if any((channel.xSampling, channel.ySampling) != (1, 1) for channel in first["channels"]):
        raise FormatError(f"{file}: some of its channels are subsampled. {_REMEDY}")
    return _depth_channels(file, [channel.name for channel in first["channels"]])


def _depth_channels(file: FileContent, names: Collection[str]) -> list[str]:
    """Return one channel, or red, green and blue, which must then be equal: of a layer called depth, such as
    ViewLayer.Depth.Z of Blender beside ViewLayer.Normal.Z, or else Z, or else of the image."""
    names = [name for name in names if name.rpartition(".")[2] != "A"] or names
    layer = [name for name in names if "depth" in name.lower().split(".")]
    layer = layer or [name for name in names if "depth" in name.lower()]
    by_name = layer or [name for name in names if name.lower().rpartition(".")[2] == "z"]
    if len(by_name) == 1 or len(names) == 1:
        return by_name or list(names)
    colours = [name for name in layer if name[-2:] in {".R", ".G", ".B"}] or [name for name in "RGB" if name in names]
    if (by_name and not layer) or len(colours) != 3:
        raise FormatError(f"{file} has the channels {', '.join(names):.200}: which one is depth is unclear. {_REMEDY}")
    return colours


# Files with a short header and float32 values, row by row.


def floats_behind(file: FileContent, start: int, shape: tuple[int, int], order: str) -> NDArray[np.float32]:
    """Read the values (H, W) after a header of `start` bytes, in byte order "<f4" or ">f4".

    Raises
    ------
    FormatError
        If there are too many pixels, or their number differs from the header.
    """
    height, width = shape
    check_memory(file, width, height)
    values = file.data[start:]
    if values.size != 4 * width * height:
        told = f"{file} has {values.size} bytes after its header, which declares {4 * width * height}"
        raise FormatError(f"{told}: it is truncated or damaged. Copy or export it again.")
    return np.frombuffer(values.tobytes(), order).astype(np.float32).reshape(shape)


# Portable float maps (PFM): text header, then float32 rows from the bottom to the top.

PFM_SUFFIX = ".pfm"

_PFM_HEADER = re.compile(rb"P([fF])\s+(\d{1,9})\s+(\d{1,9})\s+([-+]?[0-9.]{1,20}(?:[eE][-+]?\d{1,3})?)\s")
_LONGEST_PFM_HEADER = 100


def read_pfm(file: FileContent) -> NDArray[np.float32]:
    """Read values (H, W) as stored, the top row first. The header's scale is used only for the byte order.

    Raises
    ------
    FormatError
        If it is not a PFM, has colours, is truncated or has data after its end.
    """
    header = _PFM_HEADER.match(file.data[:_LONGEST_PFM_HEADER].tobytes())
    if header is None:
        raise wrong_kind(file, file.data, "a PFM")
    kind, width, height, scale = header[1], int(header[2]), int(header[3]), header[4]
    if kind == b"F":
        raise FormatError(f"{file}: this PFM has three channels. Export depth with one.")
    order = "<f4" if scale.startswith(b"-") else ">f4"
    return floats_behind(file, header.end(), (height, width), order)[::-1].copy()


# Depth maps of COLMAP: "width&height&1&" in ASCII, then float32 row by row, little-endian.

COLMAP_SUFFIX = ".bin"

_COLMAP_HEADER = re.compile(rb"(\d{1,9})&(\d{1,9})&(\d{1,9})&")
_LONGEST_COLMAP_HEADER = 30


def read_colmap(file: FileContent) -> NDArray[np.float32]:
    """Read depth (H, W) in the units of the reconstruction, 0 or negative = missing.

    Raises
    ------
    FormatError
        If it is not such a file, has several channels, is truncated or has data after its end.
    """
    header = _COLMAP_HEADER.match(file.data[:_LONGEST_COLMAP_HEADER].tobytes())
    if header is None and kind_of_file(file, file.data) is None:
        told = f"{file} is neither a depth map of COLMAP (width&height&1&...) nor 512 x 424 float32 of a Kinect v2"
        raise FormatError(f"{told}. Save other numbers as NPY: {RAW_NUMBERS}.")
    if header is None:
        raise wrong_kind(file, file.data, "a depth map of COLMAP, which begins with width&height&1&")
    width, height, channels = map(int, header.groups())
    if channels != 1:
        raise FormatError(f"{file} has {channels} channels; depth has one, normals three. Give a file of depth_maps.")
    return floats_behind(file, header.end(), (height, width), "<f4")


# Depth of the Kinect v2, as libfreenect2 gives it: float32 without a header, row by row.

KINECT_V2_SUFFIXES = ".raw", COLMAP_SUFFIX
_KINECT_V2_SHAPE = 424, 512


def read_kinect_v2(file: FileContent) -> NDArray[np.float32]:
    """Read depth [mm], float32 (424, 512), 0 = missing, from a file for which `is_kinect_v2` is true."""
    return np.frombuffer(file.data.tobytes(), "<f4").astype(np.float32).reshape(_KINECT_V2_SHAPE)


def is_kinect_v2(file: FileContent) -> bool:
    """Whether a file with one of the suffixes, which COLMAP's depth maps also have, is one of a Kinect v2."""
    return file.data.size == 4 * math.prod(_KINECT_V2_SHAPE) and not _COLMAP_HEADER.match(
        file.data[:_LONGEST_COLMAP_HEADER].tobytes()
    )


def read_bin(file: FileContent) -> NDArray[np.float32]:
    """Read a depth map of COLMAP, or of a Kinect v2; raises FormatError as `read_colmap`."""
    return read_kinect_v2(file) if is_kinect_v2(file) else read_colmap(file)


# Depth snapshots of the RealSense Viewer: 16-bit values without a header, and a table beside them.

_FORMAT = "Z16"
_MOST_LINES = 1000


def read_viewer_raw(file: FileContent) -> NDArray[np.uint16]:
    """Read depth in the camera's units, uint16 (H, W), 0 = missing.

    The table NAME_metadata.csv that the viewer writes beside NAME.raw states its size.

    Raises
    ------
    FormatError
        If there is no such table, or it states no size, another format, or another number of values than the file has.
    """
    beside = file.path.with_name(f"{file.path.stem}_metadata.csv")
    told = f"{file} has {file.data.size} bytes, not those of 512 x 424 float32 of a Kinect v2, and {beside.name} of the"
    remedy = f"Put it there, or save the numbers as NPY: {RAW_NUMBERS}."
    with told_as(FormatError, f"{told} RealSense Viewer is missing. {remedy}", InputError):
        table = read_file(beside)
    stated = table_of_names(table.data.tobytes().decode("utf-8-sig", "replace"))
    told = f"{table} does not state Resolution x and Resolution y. Copy it again."
    with told_as(FormatError, told, (KeyError, ValueError)):
        width, height = int(stated["resolution x"]), int(stated["resolution y"])
    if (kind := stated.get("format", _FORMAT).upper()) != _FORMAT:
        raise FormatError(f"{file} has the format {kind:.20}, not {_FORMAT}. Give the file of the depth stream.")
    check_memory(file, width, height)
    if min(width, height) < 1 or file.data.size != 2 * width * height:
        told = f"{file} has {file.data.size} bytes, but {beside.name} states {width} x {height} pixels of 2 bytes"
        raise FormatError(f"{told}: it is truncated or of another image. Copy both again.")
    return np.frombuffer(file.data.tobytes(), "<u2").astype(np.uint16).reshape(height, width)


def table_of_names(text: str) -> dict[str, str]:
    """The second column of a comma-separated table by the first, in lower case; the first of equal names counts.

    Examples
    --------
    >>> table_of_names("Frame Info:\\nResolution x,848\\nFx, 421.5")
    {'resolution x': '848', 'fx': '421.5'}
    """
    rows = (line.split(",") for line in text.splitlines()[:_MOST_LINES])
    found: dict[str, str] = {}
    for name, value in (row[:2] for row in rows if len(row) > 1):
        found.setdefault(name.strip().lower(), value.strip())
    return found
