"""Recordings of Record3D (.r3d): a zip with colour as JPEG, and depth and confidence packed by LZFSE."""

from __future__ import annotations

import math
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, parse_json
from .._runtime.formatting import as_float
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from ..data.camera import Camera, Cameras, fitted
from ..errors import FormatError, InputError, told_as
from ..io.images import image_header, read_colour
from .recording import RecordedFrame, Recording, part_of
from .trajectories import OPENGL_AXES, posed

_DEPTH = re.compile(r"rgbd/(\d{1,9})\.depth")


class Record3D(Recording):
    """A recording of Record3D. Keys are the numbers of its frames; confidence is 0 to 2."""

    kind = "a recording of Record3D"
    suffixes = (".r3d",)
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._zip = zipfile.ZipFile(path)
        self._names = frozenset(self._zip.namelist())
        numbers = sorted(int(found[1]) for name in self._names if (found := _DEPTH.fullmatch(name)))
        self.frames = {str(number): number for number in numbers if f"rgbd/{number}.jpg" in self._names}
        if not self.frames:
            raise FormatError(f"{path} has no frames: it contains no rgbd/0.jpg with rgbd/0.depth.")
        metadata = self._member("metadata")
        self._metadata: dict[str, Any] = parse_json(metadata.data.tobytes(), metadata, "Export it again.")
        self._depth_size = self._size("dw", "dh")
        times = [self._time(key) for key in self.frames]
        self.times = tuple(time for time in times if time is not None and math.isfinite(time))
        if len(self.times) < len(times):
            self.times = ()

    def close(self) -> None:
        self._zip.close()

    def frame(self, key: str) -> RecordedFrame:
        jpeg, depth = self._jpeg(key), self._member(f"rgbd/{key}.depth")
        width, height = self._depth_size
        values = np.frombuffer(_unpacked(depth), "<f4").astype(np.float32).reshape(height, width)
        confidence = None
        if f"rgbd/{key}.conf" in self._names:
            levels = _unpacked(self._member(f"rgbd/{key}.conf"))
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
        check_memory(self.path, size[0], size[1])
        return size[0], size[1]

    def _jpeg(self, key: str) -> FileContent:
        return self._member(f"rgbd/{self.at(key)}.jpg")

    def _member(self, name: str) -> FileContent:
        return part_of(f"{self.path}/{name}", self._zip.read(name))


def _unpacked(file: FileContent) -> bytes:
    """Data of LZFSE (Apple). What damaged data ask for is limited by the memory of this process."""
    lzfse = optional("lzfse", "ilf-studio[sensors]", "Reading depth of Record3D")
    return bytes(lzfse.decompress(file.data.tobytes()))


def _floats(values: Any, count: int) -> list[float] | None:
    """A list of so many numbers; None for anything else."""
    if not (isinstance(values, list) and len(values) == count and all(isinstance(n, int | float) for n in values)):
        return None
    return [as_float(value) for value in values]
