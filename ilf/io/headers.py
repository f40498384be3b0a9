"""What the first bytes of an image file say: format and size, before anything is decoded.

The decoder reports nothing but "no" and would allocate whatever a header asks for, so format, size and (where
the format allows) completeness are checked here first.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass

from ..errors import FormatError

_TIFF_WIDTH, _TIFF_HEIGHT, _TIFF_ORIENTATION = 256, 257, 274
_TIFF_NUMBERS = {3: "H", 4: "I"}
# start of frame: every marker C0-CF but the tables DHT, JPG and DAC
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_WITHOUT_LENGTH = frozenset({0x01, *range(0xD0, 0xD9)})


@dataclass(frozen=True)
class ImageHeader:
    """Format name and size in pixels; `orientation_at` is the byte offset of a TIFF's orientation tag."""

    kind: str
    width: int
    height: int
    orientation_at: int | None = None


def image_header(data: bytes) -> ImageHeader:
    """Read the header of a PNG, JPEG, TIFF, PGM or PPM file.

    Raises
    ------
    FormatError
        If it is none of these, or is truncated or damaged. The message does not name the file.
    """
    reader = next((reader for magic, reader in _READERS.items() if data.startswith(magic)), None)
    if reader is None:
        raise FormatError("this is not a PNG, JPEG, TIFF or PGM image, whatever its name says")
    try:
        header = reader(data)
    except (struct.error, IndexError) as error:
        raise FormatError("the file is truncated: its end is missing") from error
    if header.width < 1 or header.height < 1:
        raise FormatError("the file is damaged: its header gives no image size")
    return header


def _png(data: bytes) -> ImageHeader:
    view, position, size = memoryview(data), 8, (0, 0)
    while True:
        length, kind = struct.unpack_from(">I4s", data, position)
        (checksum,) = struct.unpack_from(">I", data, position + 8 + length)
        if zlib.crc32(view[position + 4 : position + 8 + length]) != checksum:
            raise FormatError("the file is damaged: a checksum does not fit")
        if kind == b"IHDR":
            size = struct.unpack_from(">II", data, position + 8)
        if kind == b"IEND":
            return ImageHeader("PNG", *size)
        position += 12 + length


def _jpeg(data: bytes) -> ImageHeader:
    position = 2
    while True:
        if data[position] != 0xFF:
            raise FormatError("the file is damaged: a JPEG marker is missing")
        marker = data[position + 1]
        if marker == 0xFF:
            position += 1
        elif marker in _JPEG_WITHOUT_LENGTH:
            position += 2
        elif marker in _JPEG_FRAMES:
            height, width = struct.unpack_from(">HH", data, position + 5)
            return ImageHeader("JPEG", width, height)
        else:
            position += 2 + struct.unpack_from(">H", data, position + 2)[0]


def _tiff(data: bytes) -> ImageHeader:
    order = "<" if data[:2] == b"II" else ">"
    version, directory = struct.unpack_from(order + "HI", data, 2)
    if version != 42:
        raise FormatError("this kind of TIFF (BigTIFF) is not supported: save it as a classic TIFF")
    values, offsets = {}, {}
    for entry in range(struct.unpack_from(order + "H", data, directory)[0]):
        at = directory + 2 + 12 * entry
        tag, kind = struct.unpack_from(order + "HH", data, at)
        if kind in _TIFF_NUMBERS:
            values[tag] = struct.unpack_from(order + _TIFF_NUMBERS[kind], data, at + 8)[0]
            offsets[tag] = at + 8
    return ImageHeader("TIFF", values.get(_TIFF_WIDTH, 0), values.get(_TIFF_HEIGHT, 0), offsets.get(_TIFF_ORIENTATION))


def _pnm(data: bytes) -> ImageHeader:
    tokens = re.sub(rb"#[^\n]*", b"", data[:4096]).split(maxsplit=3)
    if not (tokens[1].isdigit() and tokens[2].isdigit()) or max(len(tokens[1]), len(tokens[2])) > 9:
        raise FormatError("the file is damaged: its header gives no image size")
    return ImageHeader("PNM", int(tokens[1]), int(tokens[2]))


_READERS: dict[bytes, Callable[[bytes], ImageHeader]] = {
    b"\x89PNG\r\n\x1a\n": _png,
    b"\xff\xd8": _jpeg,
    b"II": _tiff,
    b"MM": _tiff,
    b"P2": _pnm,
    b"P3": _pnm,
    b"P5": _pnm,
    b"P6": _pnm,
}
