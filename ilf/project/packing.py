"""Encoding and decoding arrays: label maps and masks as PNG, everything else as npz, with limits on the size."""

from __future__ import annotations

import hashlib
import io
import re
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .._runtime.files import FileContent, zip_member
from ..data.frame import read_only
from ..errors import FormatError
from ..io.images import encode_image, image_header, read_colour
from ..io.labels import read_labels

# PNG images in strips: if few rows change, most bytes of the file stay the same.

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_ROWS = 32
_LEVEL = 6
_PLAIN, _UP = 0, 2
"""PNG filters of a row: none, and the difference from the row above."""


def png_in_strips(image: NDArray[np.uint16] | NDArray[np.bool_]) -> bytes:
    """Encode a label map (16 bits) or a mask (1 bit) as a PNG image of one channel.

    Each strip of rows is a separate chunk that does not depend on the others.

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
    """Split bytes at the strips of a PNG image; joined, the pieces give the same bytes."""
    cuts = [max(found.start() - 4, 0) for found in re.finditer(b"IDAT", content)]  # the length precedes each
    for start, stop in zip([0, *cuts], [*cuts, len(content)], strict=True):
        if stop > start:
            yield content[start:stop]


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(data, zlib.crc32(kind)))


ARRAYS = "arrays/"

MAX_UNPACKED = 2**29
"""Maximum size of an array [bytes]: the depth of the largest frame that can be read."""

_MAX_UNPACKED_TOTAL = 2 * MAX_UNPACKED + 2**20
"""Maximum total size of the arrays read from one npz [bytes]; an extrapolation has two arrays."""

_MAX_HEADER_BYTES = 1024
_NPY_ERRORS = (zipfile.BadZipFile, zlib.error, EOFError, OSError, LookupError, RuntimeError, ValueError, SyntaxError)
"""Exceptions of reading a damaged npz: NotImplementedError is a RuntimeError, decoding errors are ValueErrors."""

Array = TypeVar("Array", bound=NDArray[Any])


def array_name(content: bytes, suffix: str) -> str:
    """Return the name of a part with an array: the SHA-256 of its bytes.

    Examples
    --------
    >>> array_name(b"", ".png")[:20]
    'arrays/e3b0c44298fc1'
    """
    return f"{ARRAYS}{hashlib.sha256(content).hexdigest()}{suffix}"


def check_content(name: str, content: bytes) -> None:
    """Raise FormatError if the content of a part does not match the hash in its name."""
    digest = Path(name).stem
    if hashlib.sha256(content).hexdigest() != digest:
        raise FormatError(f"The part {name[:24]}... is damaged: its content does not match its name.")


def labels_to_bytes(labels: NDArray[np.int32]) -> tuple[bytes, str]:
    """Encode a label map as 16-bit PNG, or as npz if its labels are larger; return the bytes and the suffix."""
    if labels.size and labels.max() > np.iinfo(np.uint16).max:
        return npz({"labels": labels}), ".npz"
    return png_in_strips(labels.astype(np.uint16)), ".png"


def labels_from_bytes(name: str, content: bytes, shape: tuple[int, int]) -> NDArray[np.int32]:
    """Inverse of `labels_to_bytes`, read-only int32 (H, W); raises FormatError or InputError."""
    if name.endswith(".npz"):
        labels = Npz(name, content).array("labels", np.int32, shape)
    else:
        labels = read_labels(_image(name, content, shape), shape)
    if labels.min(initial=0) < 0:
        raise FormatError(f"The label map {name[:24]}... has negative labels.")
    return _read_only(labels)


def mask_to_bytes(mask: NDArray[np.bool_]) -> tuple[bytes, str]:
    """Encode a mask as 1-bit PNG; return the bytes and the suffix."""
    return png_in_strips(mask), ".png"


def mask_from_bytes(name: str, content: bytes, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Inverse of `mask_to_bytes`, read-only; raises FormatError or InputError."""
    return _read_only(read_labels(_image(name, content, shape), shape, what="mask") > 0)


def colour_to_bytes(rgb: NDArray[np.uint8]) -> tuple[bytes, str]:
    """Encode colour (H, W, 3), red first, as PNG; return the bytes and the suffix."""
    return encode_image(".png", np.ascontiguousarray(rgb[..., ::-1])), ".png"


def colour_from_bytes(name: str, content: bytes, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Inverse of `colour_to_bytes`, read-only; raises FormatError or InputError."""
    return _read_only(read_colour(_image(name, content, shape)))


def npz(arrays: Mapping[str, NDArray[Any]], texts: Mapping[str, bytes] | None = None) -> bytes:
    """Pack arrays and text files in one npz; equal arrays give equal bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, text in (texts or {}).items():
            packed.writestr(_entry(name), text)
        for name, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, np.ascontiguousarray(array), allow_pickle=False)
            packed.writestr(_entry(f"{name}.npy"), content.getbuffer())
    return buffer.getvalue()


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name)  # with a fixed date
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


class Npz:
    """A reader of an npz in memory; the caller gives the size of each array, and no more is unpacked.

    Parameters
    ----------
    name : str
        Name of the part, for messages.
    content : bytes

    Raises
    ------
    FormatError
        If the npz is damaged; the methods raise it, too.
    """

    def __init__(self, name: str, content: bytes) -> None:
        self._name = name
        self._left = _MAX_UNPACKED_TOTAL
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(content))
        except _NPY_ERRORS as error:
            raise self._damaged(error) from error

    def array(self, name: str, dtype: DTypeLike, shape: tuple[int, ...]) -> NDArray[Any]:
        """Read an array; it must have exactly this type and shape."""
        wanted = np.dtype(dtype)
        size = wanted.itemsize * int(np.prod(shape, dtype=object))
        content = io.BytesIO(self.text(f"{name}.npy", size + _MAX_HEADER_BYTES))
        try:
            if np.lib.format.read_magic(content) != (1, 0):
                raise ValueError(f"{name} has another version")
            found_shape, fortran, found = np.lib.format.read_array_header_1_0(content)
        except _NPY_ERRORS as error:
            raise self._damaged(error) from error
        body = content.read()
        if found != wanted or found_shape != shape or (fortran and len(shape) > 1) or len(body) != size:
            raise FormatError(f"The part {self._name[:24]}... is damaged: {name} is not {shape} {wanted}.")
        return np.frombuffer(body, wanted).reshape(shape).copy()

    def text(self, name: str, at_most: int) -> bytes:
        """Read a file of at most `at_most` bytes."""
        try:
            entry = self._zip.getinfo(name)
            content = zip_member(self._zip, entry, min(at_most, MAX_UNPACKED + _MAX_HEADER_BYTES, self._left))
            self._left -= len(content)
        except _NPY_ERRORS as error:
            raise self._damaged(error) from error
        return content

    def _damaged(self, error: Exception) -> FormatError:
        return FormatError(f"The part {self._name[:24]}... is damaged ({str(error) or type(error).__name__}).")


def _image(name: str, content: bytes, shape: tuple[int, int]) -> FileContent:
    """Check the header of a PNG image, which must have this shape, and return its content."""
    header = image_header(name, content)
    if header.kind != "PNG" or (header.height, header.width) != shape:
        raise FormatError(f"The part {name[:24]}... is {header.width} x {header.height}; the frame has another size.")
    return FileContent(Path(name), np.frombuffer(content, np.uint8))


def _read_only(array: Array) -> Array:
    array.setflags(write=False)
    return read_only(array)
