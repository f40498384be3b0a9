"""Raw folders of NYU Depth V2: colour and depth of a Kinect v1, in files that are named after their times."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...camera import IMAGE_SIZES, INTRINSICS, CameraIntrinsics
from ...errors import InputError, cause
from ...registration import Camera
from ..depth_files import read_depth_values
from ..files import read_file
from ..images import read_colour
from ..time_lists import MOST_APART_S, associated
from .recording import Cameras, RecordedFrame, Recording, RecordingIndex, Topics

_NAME = re.compile(r"(?P<what>[rd])-(?P<time>\d+\.\d+)-\d+\.(?:ppm|pgm)")
_ENDING = {"r": ".ppm", "d": ".pgm"}
_GAPS = (MOST_APART_S, 0.2, 2.0, 10.0)
"""Largest gaps in time [s] by which a frame is looked for. What is paired by a smaller one is so by a larger, too."""

# camera_params.m of the data set's toolbox; its shift is taken away from its turned points
_CAMERA = "nyu-kinect-v1"
_COLOUR = Camera(
    INTRINSICS[_CAMERA], IMAGE_SIZES[_CAMERA], (0.20796615, -0.58613825, 0.00072231363, 0.0010479628, 0.49856987)
)
_DEPTH = Camera(
    CameraIntrinsics(582.62448, 582.69103, 313.04476, 238.44390, "nyu-kinect-v1-depth"),
    IMAGE_SIZES[_CAMERA],
    (-0.099897237, 0.39065325, 0.0019290593, -0.0019422022, -0.51031725),
)
_TURN = np.array(
    [
        [9.9997798940829263e-01, 5.0518419386157446e-03, 4.3011152014118693e-03],
        [-5.0359919480810989e-03, 9.9998051861143999e-01, -3.6879781309514218e-03],
        [-4.3196624923060242e-03, 3.6662365748484798e-03, 9.9998394948385538e-01],
    ]
)
_SHIFT = np.array([2.5031875059141302e-02, -2.9342312935846411e-04, 6.6238747008330102e-04])


def nyu_cameras() -> Cameras:
    """The cameras that the data set was recorded with, as its toolbox has them."""
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = _TURN.T, -_SHIFT
    return Cameras(_COLOUR, _DEPTH, motion, is_registered=False)


class NyuRawFolder(Recording):
    """Files r-TIME-NUMBER.ppm and d-TIME-NUMBER.pgm, disparity with swapped bytes. A key is the name of the colour file
    without its ending."""

    kind = "a raw folder of NYU Depth"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        found: dict[str, list[tuple[float, str]]] = {"r": [], "d": []}
        try:
            names = os.listdir(path)
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({cause(error)}). Check the name and its permissions.") from error
        for name in names:
            match = _NAME.fullmatch(name)
            if match is not None and name.endswith(_ENDING[match["what"]]):
                found[match["what"]].append((float(match["time"]), name))
        self._colours, self._depths = found["r"], found["d"]
        self._pairs: dict[float, dict[str, tuple[str, str]]] = {}

    @classmethod
    def fits(cls, path: Path) -> bool:
        if not path.is_dir():
            return False
        with os.scandir(path) as entries:
            return any(entry.name.endswith(_ENDING["d"]) and _NAME.fullmatch(entry.name) for entry in entries)

    def index(self, max_gap: float = MOST_APART_S, topics: Topics | None = None) -> RecordingIndex:
        pairs = self._paired(max_gap)
        if not pairs:
            raise InputError(
                f"{self.path}: none of {len(self._colours)} colour files (r-TIME-NUMBER.ppm) lies within {max_gap:g} s "
                "of a depth file. Allow a larger gap (--max-gap)."
            )
        notes = [
            f"{lonely} {what} file{'s' * (lonely != 1)} left out: there is no {other} file {max_gap:g} s near."
            for what, other, files in (("colour", "depth", self._colours), ("depth", "colour", self._depths))
            if (lonely := len(files) - len(pairs))
        ]
        times = {Path(name).stem: time for time, name in self._colours}
        return RecordingIndex(tuple(pairs), tuple(times[key] for key in pairs), tuple(notes))

    def frame(self, key: str) -> RecordedFrame:
        colour, depth = (read_file(self.path / name) for name in self._files(key))
        return RecordedFrame(
            read_colour(colour), read_depth_values(depth), colour.sha256, depth.sha256, "nyu-raw", time=_time(key)
        )

    def colour(self, key: str) -> NDArray[np.uint8]:
        return read_colour(self.path / self._files(key)[0])

    def cameras(self, key: str) -> Cameras:
        return nyu_cameras()

    def _paired(self, max_gap: float) -> dict[str, tuple[str, str]]:
        """Key -> files of colour and depth."""
        if max_gap not in self._pairs:
            pairs = associated(self._colours, self._depths, max_gap)
            self._pairs[max_gap] = {Path(colour).stem: (colour, depth) for colour, depth in pairs}
        return self._pairs[max_gap]

    def _files(self, key: str) -> tuple[str, str]:
        found = next((pairs[key] for gap in _GAPS if key in (pairs := self._paired(gap))), None)
        if found is None:
            raise self.unknown(key)
        return found


def _time(key: str) -> float:
    return float(key.split("-")[1])
