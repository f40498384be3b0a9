"""Recordings of Record3D (.r3d): a zip with colour as JPEG, and depth and confidence packed by LZFSE."""

from __future__ import annotations

import math
import re
import struct
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.closing import closed_on_error
from .._runtime.files import FileContent, open_file, parse_json, zip_member
from .._runtime.formatting import as_float
from .._runtime.installation import optional
from ..data.camera import Camera, Cameras, fitted
from ..errors import FormatError, InputError, cause, told_as
from ..io.images import check_pixel_count, image_header, read_colour
from .poses import OPENGL_AXES, posed
from .recording import RecordedFrame, Recording, part_of

# Data compressed by LZFSE (Apple): unpacked only if its size is as expected.

_END, _PLAIN, _PACKED, _LZVN = b"bvx$", b"bvx-", b"bvx2", b"bvxn"
_MIN_BLOCK_BYTES = 10_000
"""Minimum number of bytes in a block of an encoder, except for the last one."""


def unpacked(file: FileContent, size: int) -> bytes:
    """Decompress data packed by LZFSE.

    The decoder allocates as much memory as the data require, so the sizes announced by the blocks are summed first.

    Parameters
    ----------
    file : FileContent
    size : int
        Expected number of bytes.

    Raises
    ------
    InputError
        If the package for LZFSE is not installed.
    FormatError
        If the data are damaged or have another size.
    """
    lzfse = optional("lzfse", "ilf-studio[sensors]", "Reading depth of Record3D")
    data = file.data.tobytes()
    try:
        if _announced_size(data, size) != size:
            raise ValueError(f"it does not announce {size} bytes")
        found = bytes(lzfse.decompress(data))
    except (lzfse.error, ValueError, struct.error, MemoryError) as error:
        raise FormatError(f"{file} cannot be unpacked ({error!s:.80}): it is truncated or damaged.") from error
    if len(found) != size:
        raise FormatError(f"{file} has {len(found)} bytes instead of {size}: it is truncated or damaged.")
    return found


def _announced_size(data: bytes, max_size: int) -> int:
    """Total number of bytes that the blocks announce."""
    at, total, blocks = 0, 0, 0
    while (kind := data[at : at + 4]) != _END:
        (raw,) = struct.unpack_from("<I", data, at + 4)
        if kind == _PLAIN:
            length = 8 + raw
        elif kind == _LZVN:
            length = 12 + int(struct.unpack_from("<I", data, at + 8)[0])
        elif kind == _PACKED:  # lengths of its header and of its literal and match payloads, 20 bits each
            first, second, third = struct.unpack_from("<3Q", data, at + 8)
            length = (third & 0xFFFFFFFF) + (first >> 20 & 0xFFFFF) + (second >> 40 & 0xFFFFF)
        else:
            raise ValueError("a block is of an unknown kind")
        at, total, blocks = at + length, total + raw, blocks + 1
        if total > max_size or blocks > max_size // _MIN_BLOCK_BYTES + 2:
            raise ValueError("it contains more than it should")
    return total


_METADATA = "metadata"
_DEPTH = re.compile(r"rgbd/(\d{1,9})\.depth")
_MAX_MEMBER_BYTES = 2**28
"""Maximum size of an unpacked member of the zip."""


class Record3D(Recording):
    """A recording of Record3D. Keys are the numbers of its frames; confidence is 0 to 2."""

    kind = "a recording of Record3D"
    suffixes = (".r3d",)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = open_file(path)
        try:
            self._zip = zipfile.ZipFile(self._file)
        except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
            self._file.close()
            raise FormatError(
                f"{path} is not a complete recording of Record3D ({cause(error):.80}). Export it again."
            ) from error
        with closed_on_error(self):
            self._names = frozenset(self._zip.namelist())
            numbers = sorted(int(found[1]) for name in self._names if (found := _DEPTH.fullmatch(name)))
            self.frames = {str(number): number for number in numbers if f"rgbd/{number}.jpg" in self._names}
            if not self.frames:
                raise FormatError(f"{path} has no frames: it contains no rgbd/0.jpg with rgbd/0.depth.")
            self._metadata = self._read_metadata()
            self._depth_size = self._size("dw", "dh")
        times = [self._time(key) for key in self.frames]
        self.times = tuple(time for time in times if time is not None and math.isfinite(time))
        if len(self.times) < len(times):
            self.times = ()

    def close(self) -> None:
        self._zip.close()
        self._file.close()

    def frame(self, key: str) -> RecordedFrame:
        jpeg, depth = self._jpeg(key), self._member(f"rgbd/{key}.depth")
        width, height = self._depth_size
        values = np.frombuffer(unpacked(depth, 4 * width * height), "<f4").astype(np.float32).reshape(height, width)
        confidence = None
        if f"rgbd/{key}.conf" in self._names:
            levels = unpacked(self._member(f"rgbd/{key}.conf"), width * height)
            confidence = np.frombuffer(levels, np.uint8).reshape(height, width)
        hashes, time = (jpeg.sha256, depth.sha256), self._time(key)
        return RecordedFrame(read_colour(jpeg), values, *hashes, "m", time=time, confidence=confidence)

    def colour(self, key: str) -> NDArray[np.uint8]:
        return read_colour(self._jpeg(key))

    def cameras(self, key: str) -> Cameras:
        jpeg = self._jpeg(key)
        header = image_header(jpeg, jpeg.data.tobytes())
        with told_as(FormatError, f"{self.path}: the camera of frame {key} is invalid ({{error}})", InputError):
            return Cameras.of_one_view(fitted(self._camera(key), (header.height, header.width)), self._depth_size)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        numbers = _floats(self._frame_entry("poses", key), 7)
        found = None if numbers is None else posed(numbers[:4], numbers[4:])
        return None if found is None else found @ OPENGL_AXES

    def _camera(self, key: str) -> Camera:
        """The camera for the image size in the metadata: those of the frame, or else of the recording, whose matrix is
        stored by columns."""
        numbers = self._frame_entry("perFrameIntrinsicCoeffs", key)
        if numbers is None:
            matrix = self._metadata.get("K")
            numbers = [matrix[at] for at in (0, 4, 6, 7)] if isinstance(matrix, list) and len(matrix) == 9 else None
        if (stated := _floats(numbers, 4)) is None:
            raise FormatError("its metadata have no K of nine numbers")
        fx, fy, cx, cy = stated
        return Camera(fx, fy, cx, cy, size=self._size("w", "h"))

    def _time(self, key: str) -> float | None:
        time = self._frame_entry("frameTimestamps", key)
        return as_float(time) if isinstance(time, int | float) else None

    def _frame_entry(self, name: str, key: str) -> Any:
        """The entry for a frame in a list of the metadata; None if there is none."""
        values, number = self._metadata.get(name), self.at(key)
        return values[number] if isinstance(values, list) and number < len(values) else None

    def _size(self, width: str, height: str) -> tuple[int, int]:
        size = self._metadata.get(width), self._metadata.get(height)
        if not (isinstance(size[0], int) and isinstance(size[1], int) and size[0] > 0 and size[1] > 0):
            raise FormatError(f"{self.path}: its metadata must have {width} and {height}, in pixels, not {size!r:.60}.")
        check_pixel_count(self.path, size[0], size[1])
        return size[0], size[1]

    def _read_metadata(self) -> dict[str, Any]:
        if _METADATA not in self._names:
            raise FormatError(f"{self.path} has no {_METADATA} of Record3D. Export it again.")
        content = self._member(_METADATA)
        metadata = parse_json(content.data.tobytes(), content, "Export it again.")
        if not isinstance(metadata, dict):
            raise FormatError(f"{content} must contain a JSON object. Export the recording again.")
        return metadata

    def _jpeg(self, key: str) -> FileContent:
        return self._member(f"rgbd/{self.at(key)}.jpg")

    def _member(self, name: str) -> FileContent:
        path = f"{self.path}/{name}"
        try:
            return part_of(path, zip_member(self._zip, self._zip.getinfo(name), _MAX_MEMBER_BYTES))
        except (zipfile.BadZipFile, zlib.error, OSError, RuntimeError, EOFError, ValueError) as error:
            raise FormatError(f"{path} is damaged ({cause(error):.80}). Export the recording again.") from error


def _floats(values: Any, count: int) -> list[float] | None:
    """A list of so many numbers; None for anything else."""
    if not (isinstance(values, list) and len(values) == count and all(isinstance(n, int | float) for n in values)):
        return None
    return [as_float(value) for value in values]
