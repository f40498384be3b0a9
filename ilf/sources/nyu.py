"""NYU Depth V2: the labelled file (nyu_depth_v2_labeled.mat) and the raw folders."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.closing import Closeable
from .._runtime.files import existing_file, read_file
from .._runtime.formatting import counted
from ..data.camera import INTRINSICS, Camera, Cameras
from ..errors import FormatError, InputError, cause
from ..io.depth import read_depth_values
from ..io.hdf5 import dataset, open_hdf5, rows
from ..io.images import check_pixel_count, read_colour
from .recording import RecordedFrame, Recording, RecordingIndex, Topics, sha256_of
from .times import MAX_TIME_GAP_S, associated, gap_text

# NYU Depth V2's labelled file, nyu_depth_v2_labeled.mat: 1449 frames in one MATLAB v7.3 (HDF5) file.
#
# MATLAB stores arrays in column-major order, so their axes are reversed in HDF5: images (N, 3, W, H) and rawDepths
# (N, W, H).

MAT_SUFFIX = ".mat"
CAMERA = "nyu-kinect-v1"
"""Preset of its intrinsics."""

_IMAGES, _RAW = "images", "rawDepths"


class NyuLabelled(Closeable):
    """The labelled file, open; frames are read one at a time. A context manager.

    Parameters
    ----------
    path : path-like

    Raises
    ------
    InputError
        If there is no such file, or the package that reads it is missing.
    FormatError
        If it is not a MATLAB v7.3 file, or lacks images or rawDepths of the right form.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        if not os.path.isfile(self.path) or self.path.stat().st_size == 0:
            existing_file(self.path)  # raises the precise error
        self._file = open_hdf5(self.path, str(self.path), "Reading NYU Depth V2's labelled file")
        try:
            self._data = self._checked()
        except FormatError:
            self._file.close()
            raise

    def _checked(self) -> dict[str, Any]:
        """Images and rawDepths, checked for type and shape."""
        found = {}
        for name, dimensions, kind in ((_IMAGES, 4, "u"), (_RAW, 3, "f")):
            found[name] = dataset(self._file, name, kind, dimensions, str(self.path))
            if found[name] is None:
                raise FormatError(
                    f"{self.path} has no {name} in the form of NYU Depth V2's labelled file. Check that this is "
                    "nyu_depth_v2_labeled.mat."
                )
        shapes = {name: data.shape for name, data in found.items()}
        count, channels, *size = shapes[_IMAGES]
        if channels != 3 or shapes[_RAW] != (count, *size):
            raise FormatError(
                f"{self.path}: images {shapes[_IMAGES]} and rawDepths {shapes[_RAW]} do not fit each other; they "
                "should be (N, 3, W, H) and (N, W, H)."
            )
        check_pixel_count(self.path, *size)
        return found

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of its frames in pixels."""
        width, height = self._data[_RAW].shape[1:]
        return int(width), int(height)

    def __len__(self) -> int:
        return int(self._data[_RAW].shape[0])

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def colour(self, index: int) -> NDArray[np.uint8]:
        """Colour of a frame, uint8 (H, W, 3)."""
        return np.ascontiguousarray(self._read(_IMAGES, index).transpose(2, 1, 0))

    def measured(self, index: int) -> NDArray[np.float32]:
        """Measured depth of a frame, registered to colour [m], shape (H, W), 0 = missing."""
        return np.ascontiguousarray(self._read(_RAW, index).T, np.float32)

    def _read(self, name: str, index: int) -> NDArray[Any]:
        if not 0 <= index < len(self):
            raise InputError(f"{self.path} has no frame {index + 1}; it has 1 to {len(self)}.")
        return rows(self._data[name], index, str(self.path))


class NyuLabelledFrames(Recording):
    """The labelled file as a recording. Its frames have no ground truth: depth in the holes of `depths` is not
    measured."""

    kind = "NYU Depth V2's labelled file"
    suffixes = (MAT_SUFFIX,)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = NyuLabelled(path)

    def close(self) -> None:
        self._file.close()

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        return RecordingIndex(tuple(str(number) for number in range(1, len(self._file) + 1)))

    def frame(self, key: str) -> RecordedFrame:
        rgb, depth = self.colour(key), self._file.measured(self._at(key))
        return RecordedFrame(rgb, depth, sha256_of(rgb.tobytes()), sha256_of(depth.tobytes()), "m")

    def colour(self, key: str) -> NDArray[np.uint8]:
        return self._file.colour(self._at(key))

    def cameras(self, key: str) -> Cameras:
        self._at(key)
        camera = INTRINSICS[CAMERA]
        return Cameras.registered(camera if camera.size == self._file.size else None)

    def _at(self, key: str) -> int:
        if not key.isdecimal() or not 1 <= int(key) <= len(self._file) or str(int(key)) != key:
            raise self.unknown(key)
        return int(key) - 1


# Raw folders of NYU Depth V2: colour and depth of a Kinect v1, in files with times in their names.

_NAME = re.compile(r"(?P<what>[rd])-(?P<time>\d+\.\d+)-\d+\.(?:ppm|pgm)")
_ENDING = {"r": ".ppm", "d": ".pgm"}
_GAPS = (MAX_TIME_GAP_S, 0.2, 2.0, 10.0)
"""Maximum time gaps [s] for finding a frame. Images paired with a smaller gap are also paired with a larger one."""

# camera_params.m of the data set's toolbox; its translation is subtracted from the rotated points
_COLOUR = replace(INTRINSICS[CAMERA], distortion=(0.20796615, -0.58613825, 0.00072231363, 0.0010479628, 0.49856987))
_DEPTH = Camera(
    582.62448,
    582.69103,
    313.04476,
    238.44390,
    "nyu-kinect-v1-depth",
    _COLOUR.size,
    (-0.099897237, 0.39065325, 0.0019290593, -0.0019422022, -0.51031725),
)
_ROTATION = np.array(
    [
        [9.9997798940829263e-01, 5.0518419386157446e-03, 4.3011152014118693e-03],
        [-5.0359919480810989e-03, 9.9998051861143999e-01, -3.6879781309514218e-03],
        [-4.3196624923060242e-03, 3.6662365748484798e-03, 9.9998394948385538e-01],
    ]
)
_TRANSLATION = np.array([2.5031875059141302e-02, -2.9342312935846411e-04, 6.6238747008330102e-04])


def nyu_cameras() -> Cameras:
    """The cameras of the data set, from its toolbox."""
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = _ROTATION.T, -_TRANSLATION
    return Cameras(_COLOUR, _DEPTH, motion)


class NyuRawFolder(Recording):
    """A folder of files r-TIME-NUMBER.ppm and d-TIME-NUMBER.pgm (disparity with swapped bytes). A key is the name of
    the colour file without extension."""

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

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        pairs = self._paired(max_gap)
        if not pairs:
            raise InputError(f"{self.path}: {gap_text(self._colours, self._depths, max_gap)}")
        notes = [
            f"{counted(unmatched, f'{what} file')} left out: there is no {other} file within {max_gap:g} s."
            for what, other, files in (("colour", "depth", self._colours), ("depth", "colour", self._depths))
            if (unmatched := len(files) - len(pairs))
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
        """Key -> colour and depth file."""
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
