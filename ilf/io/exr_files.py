"""Depth of OpenEXR files."""

from __future__ import annotations

import contextlib
import io
import os
import threading
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from ..extras import optional
from .files import MAX_FILE_BYTES, FileContent
from .images import check_pixel_count

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
