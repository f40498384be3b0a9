"""Arrays of NumPy's files, NPY and NPZ."""

from __future__ import annotations

import contextlib
import io
import lzma
import math
import os
import re
import threading
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import MAX_FILE_BYTES, FileContent
from .._runtime.installation import optional
from ..errors import FormatError
from .images import check_pixel_count

# whatever a header that is parsed as Python text can lead to
_NPY_ERRORS = (
    ValueError, TypeError, SyntaxError, ArithmeticError, OSError, EOFError, MemoryError, RecursionError,
    tokenize.TokenError,
)  # fmt: skip


def read_npy(file: FileContent) -> NDArray[Any]:
    """The array of an NPY file; raises FormatError if it is damaged or holds Python objects."""
    stream = io.BytesIO(file.data.data)
    try:
        # np.load would otherwise go on to try archives and pickles
        version = np.lib.format.read_magic(stream)
        read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that Python 2 has written it is no harm
            shape, in_columns, dtype = read_header(stream)
        if dtype.hasobject:
            raise ValueError("it holds Python objects")
        if min(shape, default=0) < 0:
            raise ValueError("a length is negative")
        # what a header asks for must be there before any memory is taken
        wanted, there = math.prod(shape) * dtype.itemsize, file.data.size - stream.tell()
        if wanted > there:
            raise ValueError(f"{wanted} bytes of values are announced, {there} are there")
        values = np.frombuffer(file.data, dtype, math.prod(shape), stream.tell())
    except _NPY_ERRORS as error:
        raise FormatError(
            f"{file}: this NPY cannot be read ({error!s:.120}): it is truncated, damaged, or holds Python "
            "objects. Save a plain float32 or uint16 array with numpy.save."
        ) from error
    if len(shape) >= 2:
        check_pixel_count(file, shape[1], shape[0])
    return values.reshape(shape, order="F" if in_columns else "C").copy(order="C")


def read_npz(file: FileContent, names: tuple[str, ...]) -> NDArray[Any]:
    """An array of an NPZ file: its only one, or the first of these names that is there.

    Raises
    ------
    FormatError
        If there is none of them among several, or it cannot be read.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(file.data.tobytes())) as archive:
            members = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
            name = next((name for name in names if name in members), None)
            if name is None and len(members) == 1:
                name = next(iter(members))
            if name is None:
                raise FormatError(
                    f"{file} has {len(members)} arrays ({', '.join(sorted(members))!s:.80}) and none of them is called "
                    f"{', '.join(names)}. Save the one that counts as {names[0]}."
                )
            if members[name].file_size > MAX_FILE_BYTES:
                raise FormatError(f"{file}: {name} is larger than 1 GiB. Is this the right file?")
            data = np.frombuffer(archive.read(members[name]), np.uint8)
    except (zipfile.BadZipFile, EOFError, OSError, RuntimeError, ValueError, zlib.error, lzma.LZMAError) as error:
        raise FormatError(f"{file}: this NPZ cannot be read ({error!s:.120}). Save it again.") from error
    return read_npy(FileContent(file.path, data))


# Depth of OpenEXR files.

_MAGIC = b"\x76\x2f\x31\x01"
_DEPTH_CHANNELS = "z", "depth"
_WAY_OUT = "Export depth alone, as one channel Z."

# stdout and stderr belong to the whole process
_silent = threading.Lock()


def read_exr(file: FileContent) -> NDArray[Any]:
    """Depth (H, W) of the first part, float16, float32 or uint32: its channel Z, its only one, or three equal ones.

    Raises
    ------
    InputError
        If OpenEXR is not installed.
    FormatError
        If it is no EXR, is cut short or damaged, has too many pixels, or no channel that is depth.
    """
    openexr = optional("OpenEXR", "sequences", "Reading EXR")
    if file.data[:4].tobytes() != _MAGIC:
        raise FormatError(f"{file}: this is not an EXR, whatever its name says. Copy or export it again.")
    stream = io.BytesIO(file.data.tobytes())
    try:
        with _silence():
            headers = [part.header for part in openexr.File(stream, True, True, 0).parts]
            names = _checked(file, headers)
            stream.seek(0)
            image = openexr.File(stream, True, False, 0)  # which leaves out parts that it cannot read
        if len(image.parts) != len(headers):
            raise ValueError("its pixels cannot be decoded")
        found = [image.channels(0)[name].pixels for name in names]
    except (OSError, RuntimeError, LookupError, TypeError, ValueError, MemoryError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(
            f"{file}: this EXR cannot be read ({error!s:.120}): it is truncated, damaged or of a rare kind. Copy or "
            "export it again."
        ) from error
    if not all(np.array_equal(found[0], other, equal_nan=True) for other in found[1:]):
        raise FormatError(f"{file}: its channels {', '.join(names)} differ: this is a picture, not depth. {_WAY_OUT}")
    return np.ascontiguousarray(found[0])


def _checked(file: FileContent, headers: list[dict[str, Any]]) -> list[str]:
    """The channels of the first part that are depth; FormatError if there is none, or before memory is taken for more
    than can be meant."""
    wanted = 0
    for header in headers:
        width, height = _size(header["dataWindow"])
        check_pixel_count(file, width, height)
        wanted += 4 * width * height * len(header["channels"])
    if wanted > MAX_FILE_BYTES:
        raise FormatError(f"{file}: its channels would take {wanted / 2**30:.1f} GiB of memory. {_WAY_OUT}")
    first = headers[0]
    if not np.array_equal(first["dataWindow"], first["displayWindow"]):
        raise FormatError(f"{file}: its pixels cover only a part of the picture. Export the whole.")
    if any((channel.xSampling, channel.ySampling) != (1, 1) for channel in first["channels"]):
        raise FormatError(f"{file}: not every pixel has a value of its own in all channels. {_WAY_OUT}")
    return _depth_channels(file, [channel.name for channel in first["channels"]])


def _size(window: tuple[NDArray[np.int32], NDArray[np.int32]]) -> tuple[int, int]:
    least, most = ([int(number) for number in corner] for corner in window)
    return most[0] - least[0] + 1, most[1] - least[1] + 1


def _depth_channels(file: FileContent, names: Collection[str]) -> list[str]:
    """One channel, or red, green and blue, which must then be equal."""
    by_name = [name for name in names if name.lower().rpartition(".")[2] in _DEPTH_CHANNELS]
    if len(by_name) == 1 or len(names) == 1:
        return by_name or list(names)
    colours = [name for name in ("R", "G", "B") if name in names]
    if by_name or len(colours) != 3:
        raise FormatError(f"{file} has the channels {', '.join(names):.200}: which is depth? {_WAY_OUT}")
    return colours


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Without what the package prints of damaged files, in Python and past it."""
    with _silent, contextlib.redirect_stdout(io.StringIO()), contextlib.ExitStack() as after:
        try:
            kept = os.dup(2)
        except OSError:  # a program without a terminal may have no stderr
            yield
            return
        after.callback(os.close, kept)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        after.callback(os.close, nowhere)
        os.dup2(nowhere, 2)
        after.callback(os.dup2, kept, 2)
        yield


# Files that are a short header and float32 values, row by row.


def floats_behind(file: FileContent, start: int, shape: tuple[int, int], order: str) -> NDArray[np.float32]:
    """The values (H, W) behind a header of `start` bytes, in an order of bytes, "<f4" or ">f4".

    Raises
    ------
    FormatError
        If there are too many pixels, or others than the header announces.
    """
    height, width = shape
    check_pixel_count(file, width, height)
    values = file.data[start:]
    if values.size != 4 * width * height:
        raise FormatError(
            f"{file}: {width} x {height} pixels are announced, which are {4 * width * height} bytes, and {values.size} "
            "are there: it is truncated or damaged. Copy or export it again."
        )
    return np.frombuffer(values.tobytes(), order).astype(np.float32).reshape(shape)


# Portable float maps (PFM): text header, then float32 rows from the bottom to the top.

_PFM_HEADER = re.compile(rb"P([fF])\s+(\d{1,9})\s+(\d{1,9})\s+([-+]?[0-9.]{1,20}(?:[eE][-+]?\d{1,3})?)\s")
_LONGEST_PFM_HEADER = 100


def read_pfm(file: FileContent) -> NDArray[np.float32]:
    """Values (H, W) as they are stored, the top row first. The header's scale tells the byte order alone.

    Raises
    ------
    FormatError
        If it is no PFM, has colours, is cut short or goes on after its end.
    """
    header = _PFM_HEADER.match(file.data[:_LONGEST_PFM_HEADER].tobytes())
    if header is None:
        raise FormatError(f"{file}: this is not a PFM, whatever its name says. Copy or export it again.")
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
    """Depth (H, W) in the units of the reconstruction, 0 or negative = missing.

    Raises
    ------
    FormatError
        If it is no such file, has several channels, is cut short or goes on after its end.
    """
    header = _COLMAP_HEADER.match(file.data[:_LONGEST_COLMAP_HEADER].tobytes())
    if header is None:
        raise FormatError(f"{file}: a depth map of COLMAP begins with width&height&1&, and this does not.")
    width, height, channels = map(int, header.groups())
    if channels != 1:
        raise FormatError(
            f"{file} has {channels} channels, as normal maps have, where depth has one. Give the file of depth_maps."
        )
    return floats_behind(file, header.end(), (height, width), "<f4")
