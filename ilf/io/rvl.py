"""Depth compressed by RVL, as in ROS's compressedDepth: Wilson, "Fast lossless depth image compression", 2017."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from .._runtime.memory import check_memory
from ..errors import FormatError

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
