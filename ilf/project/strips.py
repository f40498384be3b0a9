"""PNG images in strips: where few rows have changed, most of the file is the same as before, byte by byte."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_ROWS = 32
_LEVEL = 6
_PLAIN, _UP = 0, 2
"""How PNG filters a row: not at all, or as the difference from the row above."""


def png_in_strips(image: NDArray[np.uint16] | NDArray[np.bool_]) -> bytes:
    """A label map, 16 bits, or a mask, 1 bit, as a PNG image of one channel.

    Each strip of rows is a chunk of its own that depends on nothing outside.

    Parameters
    ----------
    image : ndarray of uint16 or bool, shape (H, W)

    Returns
    -------
    bytes

    Examples
    --------
    >>> mask = np.zeros((200, 300), bool)
    >>> before = png_in_strips(mask)
    >>> mask[70:80, 40:90] = True
    >>> after = png_in_strips(mask)
    >>> [one == other for one, other in zip(chunks(before), chunks(after), strict=True)].count(False)
    2
    """
    height, width = image.shape
    if image.dtype == bool:
        rows, depth = np.packbits(image, axis=1), 1
    else:
        rows, depth = image.astype(">u2").view(np.uint8).reshape(height, width * 2), 16
    parts = [_SIGNATURE, _chunk(b"IHDR", struct.pack(">2I5B", width, height, depth, 0, 0, 0, 0))]
    packer = zlib.compressobj(_LEVEL)
    for top in range(0, height, _ROWS):
        strip = rows[top : top + _ROWS]
        filtered = np.empty((len(strip), strip.shape[1] + 1), np.uint8)
        filtered[0, 0], filtered[1:, 0] = _PLAIN, _UP
        filtered[0, 1:] = strip[0]
        np.subtract(strip[1:], strip[:-1], out=filtered[1:, 1:])
        parts.append(_chunk(b"IDAT", packer.compress(filtered.data) + packer.flush(zlib.Z_FULL_FLUSH)))
    parts += [_chunk(b"IDAT", packer.flush()), _chunk(b"IEND", b"")]
    return b"".join(parts)


def chunks(content: bytes) -> Iterator[bytes]:
    """Bytes of any kind, cut where a PNG image has its strips; joined, they are what they were."""
    cuts = [max(found.start() - 4, 0) for found in re.finditer(b"IDAT", content)]  # each is led by its length
    for start, stop in zip([0, *cuts], [*cuts, len(content)], strict=True):
        if stop > start:
            yield content[start:stop]


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))
