"""Recordings of Stray Scanner: a folder with colour as a video, and depth and confidence as images."""

from __future__ import annotations

import csv
import io
import math
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...camera import camera_from_numbers
from ...errors import FormatError, InputError
from ...registration import Camera
from ..confidence_files import read_confidence
from ..depth_files import read_depth_values
from ..files import read_file
from ..poses import posed
from ..time_lists import MOST_APART_S
from .recording import Cameras, RecordedFrame, Recording, RecordingIndex, Topics, scaled_cameras
from .video import Video

_VIDEO, _DEPTH, _CONFIDENCE = "rgb.mp4", "depth", "confidence"
_CAMERA, _ODOMETRY = "camera_matrix.csv", "odometry.csv"
_SUFFIXES = ".png", ".npy"


class StrayScanner(Recording):
    """A recording of Stray Scanner. Keys are the names of its depth images, which are the numbers of the video's
    frames; confidence goes from 0 to 2."""

    kind = "a recording of Stray Scanner"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with os.scandir(path / _DEPTH) as entries:
            files = {Path(entry.name).stem: Path(entry.path) for entry in entries if entry.name.endswith(_SUFFIXES)}
        self._depth = {key: files[key] for key in sorted(files) if key.isdecimal() and len(key) < 10}
        if not self._depth:
            raise InputError(
                f"{path / _DEPTH} has no images whose names are numbers of frames. Export the recording again."
            )
        self._rows = self._odometry()
        self._video: Video | None = None

    @classmethod
    def fits(cls, path: Path) -> bool:
        return (path / _VIDEO).is_file() and (path / _DEPTH).is_dir()

    def close(self) -> None:
        if self._video is not None:
            self._video.close()
            self._video = None

    def index(self, max_gap: float = MOST_APART_S, topics: Topics | None = None) -> RecordingIndex:
        times = [self._rows.get(int(key), {}).get("timestamp", math.nan) for key in self._depth]
        return RecordingIndex(tuple(self._depth), tuple(times) if np.isfinite(times).all() else ())

    def frame(self, key: str) -> RecordedFrame:
        depth = read_file(self._file(key))
        values = read_depth_values(depth)
        rgb, sha256 = self._opened_video().frame(int(key))
        confidence = self.path / _CONFIDENCE / f"{key}.png"
        return RecordedFrame(
            rgb,
            values,
            sha256,
            depth.sha256,
            "mm",
            time=self._rows.get(int(key), {}).get("timestamp"),
            confidence=read_confidence(confidence, values.shape) if confidence.is_file() else None,
        )

    def colour(self, key: str) -> NDArray[np.uint8]:
        self._file(key)
        return self._opened_video().frame(int(key))[0]

    def cameras(self, key: str) -> Cameras:
        path, video = self.path / _CAMERA, self._opened_video()
        height, width = read_depth_values(self._file(key)).shape
        try:
            numbers = np.array(list(csv.reader(io.StringIO(_text(path)))), float)
            stated = Camera(camera_from_numbers(numbers, ""), video.size)
            return scaled_cameras(stated, (width, height))
        except (ValueError, InputError, csv.Error) as error:
            raise FormatError(
                f"{path} must hold a camera matrix, three numbers in three lines ({error!s:.200})."
            ) from error

    def pose(self, key: str) -> NDArray[np.float64] | None:
        row = self._rows.get(int(self._file(key).stem), {})
        numbers = [row.get(name, math.nan) for name in ("qx", "qy", "qz", "qw", "x", "y", "z")]
        return posed(numbers[:4], numbers[4:])

    def _odometry(self) -> dict[int, dict[str, float]]:
        """What is known of each frame by its number; nothing where the file is missing."""
        path = self.path / _ODOMETRY
        if not path.is_file():
            return {}
        try:
            reader = csv.DictReader(io.StringIO(_text(path)), skipinitialspace=True)
            rows = [{str(name).strip(): float(value) for name, value in row.items()} for row in reader]
            return {int(row["frame"]): row for row in rows}
        except (ValueError, TypeError, KeyError, OverflowError, csv.Error) as error:
            raise FormatError(
                f"{path} must have a line of names, with frame among them, and numbers below it ({error!s:.80})."
            ) from error

    def _file(self, key: str) -> Path:
        if key not in self._depth:
            raise self.unknown(key)
        return self._depth[key]

    def _opened_video(self) -> Video:
        if self._video is None:
            self._video = Video(self.path / _VIDEO)
        return self._video


def _text(path: Path) -> str:
    try:
        return read_file(path).data.tobytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"{path} is not a text file. Export the recording again.") from error
