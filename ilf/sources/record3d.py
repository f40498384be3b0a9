"""Recordings of Record3D (.r3d): a zip with colour as JPEG, and depth and confidence packed by LZFSE."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, parse_json
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from .._runtime.schema import converted
from ..data.camera import Camera, Cameras, fitted
from ..errors import FormatError, InputError, told_as
from ..io.images import image_header, read_colour
from .recording import RecordedFrame, Recording, part_of
from .trajectories import OPENGL_AXES, posed

_DEPTH = re.compile(r"rgbd/(\d{1,9})\.depth")
_Pixels = Annotated[int, msgspec.Meta(gt=0)]


class _Metadata(msgspec.Struct):
    """What the file `metadata` states: the sizes of colour and depth, the camera of all frames by columns, and, by the
    numbers of the frames, cameras, poses and times."""

    w: _Pixels
    h: _Pixels
    dw: _Pixels
    dh: _Pixels
    K: list[float] | None = None
    perFrameIntrinsicCoeffs: list[list[float] | None] | None = None
    poses: list[list[float] | None] | None = None
    frameTimestamps: list[float | None] | None = None


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
        file = self._member("metadata")
        with told_as(FormatError, f"{path}: {{error}} Export it again.", FormatError):
            self._metadata = converted(parse_json(file.data.tobytes(), file), _Metadata, "metadata")
        check_memory(path, self._metadata.dw, self._metadata.dh)
        times = [self._entry("frameTimestamps", key) for key in self.frames]
        self.times = () if None in times else tuple(times)

    def close(self) -> None:
        self._zip.close()

    def frame(self, key: str) -> RecordedFrame:
        jpeg, depth = self._jpeg(key), self._member(f"rgbd/{key}.depth")
        shape = self._metadata.dh, self._metadata.dw
        values = np.frombuffer(_unpacked(depth), "<f4").astype(np.float32).reshape(shape)
        confidence = None
        if f"rgbd/{key}.conf" in self._names:
            confidence = np.frombuffer(_unpacked(self._member(f"rgbd/{key}.conf")), np.uint8).reshape(shape)
        hashes, time = (jpeg.sha256, depth.sha256), self._entry("frameTimestamps", key)
        return RecordedFrame(read_colour(jpeg), values, *hashes, "m", time=time, confidence=confidence)

    def cameras(self, key: str) -> Cameras:
        jpeg, stated = self._jpeg(key), self._metadata
        header = image_header(jpeg, jpeg.data.tobytes())
        with told_as(FormatError, f"{self.path}: the camera of frame {key} is invalid ({{error}})", InputError):
            matrix = stated.K or []
            numbers = self._entry("perFrameIntrinsicCoeffs", key) or [
                matrix[at] for at in (0, 4, 6, 7) if at < len(matrix)
            ]
            if len(numbers) != 4:
                raise FormatError("its metadata have no K of nine numbers")
            fx, fy, cx, cy = numbers
            camera = Camera(fx, fy, cx, cy, size=(stated.w, stated.h))
            return Cameras.of_one_view(fitted(camera, (header.height, header.width)), (stated.dw, stated.dh))

    def pose(self, key: str) -> NDArray[np.float64] | None:
        numbers = self._entry("poses", key)
        found = posed(numbers[:4], numbers[4:]) if numbers is not None and len(numbers) == 7 else None
        return None if found is None else found @ OPENGL_AXES

    def _entry(self, name: str, key: str) -> Any:
        """The entry for a frame in a list of the metadata; None if there is none."""
        values, number = getattr(self._metadata, name) or (), self.at(key)
        return values[number] if number < len(values) else None

    def _jpeg(self, key: str) -> FileContent:
        return self._member(f"rgbd/{self.at(key)}.jpg")

    def _member(self, name: str) -> FileContent:
        return part_of(f"{self.path}/{name}", self._zip.read(name))


def _unpacked(file: FileContent) -> bytes:
    """Data of LZFSE (Apple). What damaged data ask for is limited by the memory of this process."""
    lzfse = optional("lzfse", "ilf-studio[sensors]", "Reading depth of Record3D")
    return bytes(lzfse.decompress(file.data.tobytes()))
