"""Recordings of ScanNet (.sens, version 4): colour as JPEG, depth as integers compressed by zlib."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import open_file
from .._runtime.memory import check_memory
from ..data.camera import Camera, Cameras
from ..errors import FormatError, InputError, told_as
from ..io.images import read_colour
from .recording import RecordedFrame, Recording, part_of, sha256_of
from .trajectories import checked_pose

_VERSION = 4
_MATRIX, _HEADER, _FRAME = struct.Struct("<16f"), struct.Struct("<2i4IfQ"), struct.Struct("<16f4Q")
_JPEG_OR_PNG = 1, 2
_PLAIN, _ZLIB = 0, 1


class ScanNet(Recording):
    """A recording of ScanNet. Keys are the numbers of its frames from 0; times are read as microseconds."""

    kind = "a recording of ScanNet"
    suffixes = (".sens",)
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = open_file(path)
        self._count = self._read_header()
        self.frames = {str(number): place for number, place in enumerate(self._read_positions())}
        times = tuple(time * 1e-6 for *_, time, _ in self.frames.values())
        self.times = times if any(times) else ()

    def close(self) -> None:
        self._file.close()

    def frame(self, key: str) -> RecordedFrame:
        start, colour_bytes, depth_bytes, time, _ = self.at(key)
        colour = self._bytes(start, colour_bytes)
        depth = self._bytes(start + colour_bytes, depth_bytes)
        values = np.frombuffer(self._unpacked(depth, key), "<u2").astype(np.uint16)
        return RecordedFrame(
            self._decoded(colour, key),
            values.reshape(self._depth_size[::-1]),
            sha256_of(colour),
            sha256_of(depth),
            float(self._units),
            time=time * 1e-6 if time else None,
        )

    def cameras(self, key: str) -> Cameras:
        with told_as(FormatError, f"{self.path}: its cameras are invalid ({{error}})", InputError):
            colour, depth = (
                Camera(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], size=size)
                for matrix, size in zip(self._intrinsics, (self._colour_size, self._depth_size), strict=True)
            )
            # extrinsics transform points of a camera to the device: in ScanNet itself, both are the identity
            with np.errstate(all="ignore"):  # values that are not finite are rejected where they are used
                motion = np.linalg.inv(self._extrinsics[0]) @ self._extrinsics[1]
        if colour == depth and np.array_equal(motion, np.eye(4)):
            return Cameras.registered(colour)
        return Cameras(colour, depth, motion)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        return checked_pose(np.reshape(self.at(key)[-1], (4, 4)))

    def _read_header(self) -> int:
        """Read the header; returns the number of frames."""
        version, length = struct.unpack("<IQ", self._file.read(12))
        if version != _VERSION:
            raise FormatError(f"{self.path} is not a ScanNet recording of version {_VERSION}. Copy it again.")
        self._file.seek(length, 1)
        matrices = [np.array(_MATRIX.unpack(self._file.read(_MATRIX.size)), np.float64) for _ in range(4)]
        colour_kind, self._depth_kind, *sizes, self._units, count = _HEADER.unpack(self._file.read(_HEADER.size))
        self._colour_size, self._depth_size = (sizes[0], sizes[1]), (sizes[2], sizes[3])
        for size in (self._colour_size, self._depth_size):
            check_memory(self.path, *size)
        colour_camera, colour_place, depth_camera, depth_place = (matrix.reshape(4, 4) for matrix in matrices)
        self._intrinsics, self._extrinsics = (colour_camera, depth_camera), (colour_place, depth_place)
        if colour_kind not in _JPEG_OR_PNG or self._depth_kind not in {_PLAIN, _ZLIB}:
            kinds = f"colour of kind {colour_kind} and depth of kind {self._depth_kind}"
            raise FormatError(f"{self.path} has {kinds}: only JPEG, PNG, and none or zlib for depth are supported.")
        if not (0 < self._units < 1e9 and count and min(*self._colour_size, *self._depth_size) > 0):
            raise FormatError(f"{self.path} is damaged: {count} frames, {self._units:g} units, sizes {sizes}.")
        return int(count)

    def _read_positions(self) -> list[tuple[int, int, int, int, list[float]]]:
        """Where the images of each frame begin, the sizes of colour and depth [bytes], the time of colour, and the
        pose."""
        end = self.path.stat().st_size
        places: list[tuple[int, int, int, int, list[float]]] = []
        at = self._file.tell()
        while len(places) < self._count:
            self._file.seek(at)
            *pose, time, _, colour_bytes, depth_bytes = _FRAME.unpack(self._file.read(_FRAME.size))
            start = at + _FRAME.size
            at = start + colour_bytes + depth_bytes
            if at > end:
                raise FormatError(f"{self.path} ends within frame {len(places)} of {self._count}. Copy it again.")
            places.append((start, colour_bytes, depth_bytes, time, pose))
        return places

    def _bytes(self, start: int, count: int) -> bytes:
        self._file.seek(start)
        return self._file.read(count)

    def _unpacked(self, data: bytes, key: str) -> bytes:
        wanted = 2 * self._depth_size[0] * self._depth_size[1]
        found = zlib.decompressobj().decompress(data, wanted + 1) if self._depth_kind == _ZLIB else data
        if len(found) != wanted:
            raise FormatError(f"{self.path}: the depth of frame {key} does not have the {wanted} bytes of its size.")
        return found

    def _decoded(self, data: bytes, key: str) -> NDArray[np.uint8]:
        return read_colour(part_of(f"{self.path}, colour of frame {key}", data))
