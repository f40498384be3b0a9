"""Data packed by LZFSE, Apple's compression: unpacked if it is as long as it should be."""

from __future__ import annotations

import struct

from ..errors import FormatError
from ..extras import optional

_END, _PLAIN, _PACKED, _LZVN = b"bvx$", b"bvx-", b"bvx2", b"bvxn"
_FEWEST_IN_BLOCK = 10_000
"""Bytes that an encoder puts into a block, but for the last of them."""


def unpacked(data: bytes, size: int, file: str) -> bytes:
    """Data packed by LZFSE.

    The decoder asks for whatever memory the data take, so what their blocks announce is added up first.

    Parameters
    ----------
    data : bytes
    size : int
        How many bytes it must give.
    file : str
        Where it is from, for messages.

    Raises
    ------
    InputError
        If the package that unpacks it is not installed.
    FormatError
        If it is damaged or gives another number of bytes.
    """
    lzfse = optional("lzfse", "sequences", "Reading depth of Record3D")
    try:
        if _announced(data, size) != size:
            raise ValueError(f"it does not announce {size} bytes")
        found = bytes(lzfse.decompress(data))
    except (lzfse.error, ValueError, struct.error, MemoryError) as error:
        raise FormatError(f"{file} cannot be unpacked ({error!s:.80}): it is truncated or damaged.") from error
    if len(found) != size:
        raise FormatError(f"{file} gives {len(found)} bytes in place of {size}: it is truncated or damaged.")
    return found


def _announced(data: bytes, most: int) -> int:
    """Bytes that the blocks say they hold."""
    at, total, blocks = 0, 0, 0
    while (kind := data[at : at + 4]) != _END:
        (raw,) = struct.unpack_from("<I", data, at + 4)
        if kind == _PLAIN:
            length = 8 + raw
        elif kind == _LZVN:
            length = 12 + int(struct.unpack_from("<I", data, at + 8)[0])
        elif kind == _PACKED:  # lengths of its header and of what that tells how to decode, 20 bits each
            first, second, third = struct.unpack_from("<3Q", data, at + 8)
            length = (third & 0xFFFFFFFF) + (first >> 20 & 0xFFFFF) + (second >> 40 & 0xFFFFF)
        else:
            raise ValueError("a block is of no kind that there is")
        at, total, blocks = at + length, total + raw, blocks + 1
        if total > most or blocks > most // _FEWEST_IN_BLOCK + 2:
            raise ValueError("it holds more than it should")
    return total
