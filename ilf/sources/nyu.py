"""NYU Depth V2: the labelled file (nyu_depth_v2_labeled.mat) and the raw folders."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from .._runtime.memory import check_memory
from ..data.camera import INTRINSICS, Camera, Cameras, rigid_transform
from ..errors import FormatError, InputError, told_as
from ..io.depth import read_depth_values
from ..io.hdf5 import dataset, open_hdf5
from ..io.images import read_colour
from .pairing import TimedPairs
from .recording import PairedRecording, RecordedFrame, Recording, sha256_of

# NYU Depth V2's labelled file, nyu_depth_v2_labeled.mat: 1449 frames in one MATLAB v7.3 (HDF5) file.
#
# MATLAB stores arrays in column-major order, so their axes are reversed in HDF5: images (N, 3, W, H) and rawDepths
# (N, W, H).

CAMERA = "nyu-kinect-v1"
"""Preset of its intrinsics."""

_IMAGES, _RAW = "images", "rawDepths"


class NyuLabelled(Recording):
    """The labelled file. Its frames have no ground truth: depth in the holes of `depths` is not measured."""

    kind = "NYU Depth V2's labelled file"
    suffixes = (".mat",)
    in_child = True

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = open_hdf5(path, str(path), "Reading NYU Depth V2's labelled file")
        self._images, self._raw = self._checked()
        self.frames = {str(number + 1): number for number in range(self._raw.shape[0])}

    def _checked(self) -> tuple[Any, Any]:
        """Images and rawDepths, checked for type and shape."""
        found = {
            name: dataset(self._file, name, kind, dimensions, str(self.path))
            for name, dimensions, kind in ((_IMAGES, 4, "u"), (_RAW, 3, "f"))
        }
        if lacking := [name for name, data in found.items() if data is None]:
            told = f"{self.path} has no {lacking[0]} of NYU Depth V2's labelled file"
            raise FormatError(f"{told}. Give nyu_depth_v2_labeled.mat, or depth with its colour image.")
        images, raw = found.values()
        count, channels, *size = images.shape
        if channels != 3 or raw.shape != (count, *size):
            shapes = f"images {images.shape} and rawDepths {raw.shape}"
            raise FormatError(f"{self.path}: {shapes} do not fit each other, as (N, 3, W, H) and (N, W, H) do.")
        check_memory(self.path, *size)
        return images, raw

    def close(self) -> None:
        self._file.close()

    def frame(self, key: str) -> RecordedFrame:
        rgb = self.colour(key)
        depth = np.ascontiguousarray(self._raw[self.at(key)].T, np.float32)
        return RecordedFrame(rgb, depth, sha256_of(rgb.tobytes()), sha256_of(depth.tobytes()), "m")

    def colour(self, key: str) -> NDArray[np.uint8]:
        return np.ascontiguousarray(self._images[self.at(key)].transpose(2, 1, 0))

    def cameras(self, key: str) -> Cameras:
        self.at(key)
        camera = INTRINSICS[CAMERA]
        return Cameras.registered(camera if camera.size == self._raw.shape[1:] else None)


# Raw folders of NYU Depth V2: colour and depth of a Kinect v1, in files with times in their names.

_COLOUR_NAME = re.compile(r"r-(\d+\.\d+)-\d+\.ppm")
_DEPTH_NAME = re.compile(r"d-(\d+\.\d+)-\d+\.pgm")

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


NYU_CAMERAS = Cameras(_COLOUR, _DEPTH, rigid_transform(_ROTATION.T, -_TRANSLATION))
"""The cameras of the data set, from its toolbox."""


class NyuRawFolder(PairedRecording):
    """A folder of files r-TIME-NUMBER.ppm and d-TIME-NUMBER.pgm (disparity with swapped bytes). A key is the name of
    the colour file without extension."""

    kind = "a raw folder of NYU Depth"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        with told_as(InputError, f"{path}: cannot be read ({{error}}). Check the name and its permissions.", OSError):
            names = os.listdir(path)
        colours, depths = (
            {Path(name).stem: (float(found[1]), name) for name in names if (found := pattern.fullmatch(name))}
            for pattern in (_COLOUR_NAME, _DEPTH_NAME)
        )
        self.pairs = TimedPairs(colours, depths)

    @classmethod
    def fits(cls, path: Path) -> bool:
        if not path.is_dir():
            return False
        with os.scandir(path) as entries:
            return any(_DEPTH_NAME.fullmatch(entry.name) for entry in entries)

    def frame(self, key: str) -> RecordedFrame:
        colour, depth = (read_file(self.path / name) for name in self.at(key))
        hashes, time = (colour.sha256, depth.sha256), float(key.split("-")[1])
        return RecordedFrame(read_colour(colour), read_depth_values(depth), *hashes, "nyu-raw", time=time)

    def cameras(self, key: str) -> Cameras:
        return NYU_CAMERAS
