"""An archive of NumPy arrays (.rgbd) as a kind of recording, and a layout of folders."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from ilf.data.camera import Camera, Cameras
from ilf.errors import FormatError
from ilf.sources.layout import layout_of
from ilf.sources.recording import RecordedFrame, Recording, sha256_of


class RgbdArchive(Recording):
    """A file as `numpy.savez` writes it: rgb (N, H, W, 3) uint8, depth (N, H, W) in millimetres, K (3, 3)."""

    kind = "an archive of NumPy arrays"
    suffixes = (".rgbd",)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        try:
            with np.load(path, allow_pickle=False) as arrays:
                self._rgb, self._depth, matrix = arrays["rgb"], arrays["depth"], arrays["K"]
            frames, height, width, _ = self._rgb.shape
            numbers = map(float, (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]))
            self._camera = Camera(*numbers, size=(width, height))
        except (OSError, KeyError, ValueError, IndexError, zipfile.BadZipFile) as error:
            raise FormatError(f"{path} has no rgb (N, H, W, 3), depth (N, H, W) and K (3, 3): {error}") from error
        if self._rgb.dtype != np.uint8 or self._depth.shape != (frames, height, width):
            raise FormatError(f"{path}: rgb must be uint8, and depth must have its size and number of frames.")
        self.frames = {f"{number:04d}": number for number in range(frames)}

    def frame(self, key: str) -> RecordedFrame:
        number = self.at(key)
        rgb, depth = self._rgb[number], self._depth[number]
        return RecordedFrame(rgb, depth, sha256_of(rgb.tobytes()), sha256_of(depth.tobytes()), encoding="mm")

    def cameras(self, key: str) -> Cameras:
        return Cameras.registered(self._camera)


STEREO_RIG = layout_of(
    {"rgb": "left/*.png", "depth": "range/*.png", "units": 2000, "K": "80,80,39.5,29.5", "title": "a stereo rig"},
    name="stereo-rig",
    where="ilf-example-source",
)
