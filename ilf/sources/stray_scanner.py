"""Recordings of Stray Scanner: folders with colour as a video, and depth and confidence as images."""

from __future__ import annotations

import csv
import hashlib
import math
import os
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from ..data.camera import Cameras, camera_from_numbers
from ..errors import FormatError, InputError, told_as
from ..io.depth import read_depth_values
from .naming import by_stem
from .recording import RecordedFrame, Recording, confidence_beside
from .trajectories import posed

# Reading frames of a video by their numbers.

_SEEK_DISTANCE = 60
"""Number of frames ahead from which seeking a key frame is likely faster than decoding the frames between."""


class Video:
    """The first video track of a file, open. Successive frames are decoded without seeking.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        If the package for reading videos is not installed.
    FormatError
        If it has no video; any other error if it is damaged.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        av = optional("av", "ilf-studio[sensors]", "Reading video")
        self._container = av.open(str(path), format="mov")  # a list of FFmpeg names other files
        if not self._container.streams.video:
            raise FormatError(f"{path} has no video track. Check that this is the right file.")
        self._stream = self._container.streams.video[0]
        if self._stream.codec_context is None:
            raise FormatError(f"{path}: its video codec is unknown. Copy it again.")
        self.size: tuple[int, int] = self._stream.codec_context.width, self._stream.codec_context.height
        check_memory(path, *self.size)
        self._decoding: Iterator[tuple[Any, str]] | None = None
        self._next = 0

    def close(self) -> None:
        """Close the file."""
        self._container.close()

    def frame(self, number: int) -> tuple[NDArray[np.uint8], str]:
        """Read a frame by its number from 0: uint8 (h, w, 3), RGB, as stored, never rotated; and the SHA-256 of its
        bytes in the file.

        Raises
        ------
        FormatError
            If there is no such frame, or it cannot be decoded.
        """
        times = self._times
        if number >= len(times):
            raise FormatError(f"{self.path} has {len(times)} frames, but no frame {number}: it is truncated.")
        if self._decoding is None or not 0 <= number - self._next < _SEEK_DISTANCE:
            self._container.seek(times[number], stream=self._stream)
            self._decoding = self._decoded()
        for image, sha256 in self._decoding:
            if image.pts == times[number]:
                self._next = number + 1
                return image.to_ndarray(format="rgb24"), sha256
        self._decoding = None
        raise FormatError(f"{self.path}: frame {number} cannot be decoded: the video is damaged there.")

    @cached_property
    def _times(self) -> list[int]:
        """Presentation times of all frames, sorted; the packets are not decoded."""
        return sorted(packet.pts for packet in self._container.demux(self._stream) if packet.pts is not None)

    def _decoded(self) -> Iterator[tuple[Any, str]]:
        """Frames from the current position on, with the hashes of their packets."""
        hashes: dict[int, str] = {}
        for packet in self._container.demux(self._stream):
            if packet.pts is not None:
                hashes[packet.pts] = hashlib.sha256(bytes(packet)).hexdigest()
            for image in packet.decode():
                if image.pts in hashes:
                    yield image, hashes.pop(image.pts)


_VIDEO, _DEPTH, _CONFIDENCE = "rgb.mp4", "depth", "confidence"
_CAMERA, _ODOMETRY = "camera_matrix.csv", "odometry.csv"
_SUFFIXES = ".png", ".npy"


class StrayScanner(Recording):
    """A recording of Stray Scanner. Keys are the names of its depth images, which are the frame numbers of the video;
    confidence is 0 to 2."""

    kind = "a recording of Stray Scanner"
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with os.scandir(path / _DEPTH) as entries:
            files = by_stem(Path(entry.path) for entry in entries if entry.name.endswith(_SUFFIXES))
        numbered, rows = (key for key in files if key.isdecimal() and len(key) < 10), self._odometry()
        self.frames = {key: (files[key], rows.get(int(key), {})) for key in numbered}
        if not self.frames:
            raise InputError(f"{path / _DEPTH} has no images with frame numbers as names. Export the recording again.")
        times = [row.get("timestamp", math.nan) for _, row in self.frames.values()]
        self.times = tuple(times) if np.isfinite(times).all() else ()
        self._video = Video(path / _VIDEO)

    @classmethod
    def fits(cls, path: Path) -> bool:
        return (path / _VIDEO).is_file() and (path / _DEPTH).is_dir()

    def close(self) -> None:
        self._video.close()

    def frame(self, key: str) -> RecordedFrame:
        file, row = self.at(key)
        depth = read_file(file)
        values = read_depth_values(depth)
        rgb, sha256 = self._video.frame(int(key))
        return RecordedFrame(
            rgb,
            values,
            sha256,
            depth.sha256,
            "mm",
            time=row.get("timestamp"),
            confidence=confidence_beside(self.path / _CONFIDENCE / f"{key}.png", values.shape),
        )

    def cameras(self, key: str) -> Cameras:
        path = self.path / _CAMERA
        height, width = read_depth_values(self.at(key)[0]).shape
        told = f"{path} must contain a camera matrix, three lines of three numbers ({{error}})."
        with told_as(FormatError, told, (ValueError, InputError, csv.Error)):
            numbers = np.array(list(csv.reader(_lines(path))), float)
            stated = replace(camera_from_numbers(numbers, ""), size=self._video.size)
            return Cameras.of_one_view(stated, (width, height))

    def pose(self, key: str) -> NDArray[np.float64] | None:
        _, row = self.at(key)
        numbers = [row.get(name, math.nan) for name in ("qx", "qy", "qz", "qw", "x", "y", "z")]
        return posed(numbers[:4], numbers[4:])

    def _odometry(self) -> dict[int, dict[str, float]]:
        """Frame number -> its row of the odometry; empty if the file is missing."""
        path = self.path / _ODOMETRY
        if not path.is_file():
            return {}
        told = f"{path} must have a header line with a column frame, followed by lines of numbers ({{error}})."
        with told_as(FormatError, told, (ValueError, TypeError, KeyError, OverflowError, csv.Error)):
            reader = csv.DictReader(_lines(path), skipinitialspace=True)
            rows = [{str(name).strip(): float(value) for name, value in row.items()} for row in reader]
            return {int(row["frame"]): row for row in rows}


def _lines(path: Path) -> list[str]:
    return read_file(path).data.tobytes().decode("utf-8-sig").splitlines()
