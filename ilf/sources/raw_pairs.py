"""Folders of raw pairs: colour and depth of two cameras, and a calibration.json."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from .._runtime.files import read_file, read_json
from .._runtime.formatting import counted
from .._runtime.schema import converted
from ..data.camera import Camera, Cameras, checked_transform, lens_of
from ..errors import FormatError, InputError, ParameterError, told_as
from ..io.depth import read_depth_values
from ..io.encodings import packed_channels
from ..io.images import read_colour
from .frame_folder import StatedDepth
from .naming import CALIBRATION_NAME, META_NAME, by_stem
from .recording import RecordedFrame, Recording, sha256_of

_COLOUR, _DEPTH = ("colour", "color", "rgb"), ("depth",)
_COLOUR_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".ppm")
_DEPTH_SUFFIXES = (".png", ".tif", ".tiff", ".pgm", ".npy", ".exr", ".pfm")
_MAX_CALIBRATION_BYTES = 2**20
"""Maximum size of a calibration file [bytes]."""
_SINGLE_KEY = "1"
"""Key of the pair in a folder with only one."""


class _Lens(msgspec.Struct):
    """A camera of calibration.json; its distortion is in OpenCV's order."""

    size: tuple[int, int]
    K: list[Any]
    distortion: list[float] = []
    model: str = "pinhole"


class _Calibration(StatedDepth, kw_only=True):
    colour: _Lens
    depth: _Lens
    depth_to_colour: list[Any]


class RawPairs(Recording):
    """A folder of raw pairs: either the two files `colour.*` and `depth.*`, with the key 1, or two folders of these
    names, whose common file names without extension are the keys.

    calibration.json contains `colour` and `depth`, each with `size` [width, height], `K` [fx, fy, cx, cy] and, if there
    is any, `distortion` in OpenCV's order (of a fisheye, also `model`: "fisheye"); `depth_to_colour`, the rows of the
    matrix (4, 4) that transforms points [m] of the depth camera to the colour camera; and, as in meta.json,
    `depth_units_per_m` or `depth_encoding`, and `depth_invalid`.
    """

    kind = "a folder of raw pairs"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._calibration = read_file(path / CALIBRATION_NAME)
        with told_as(FormatError, f"{path / CALIBRATION_NAME}: {{error}}", (InputError, ParameterError)):
            stated = converted(read_json(self._calibration), _Calibration, "calibration")
            motion = checked_transform(stated.depth_to_colour, "'depth_to_colour'")
            self._cameras = Cameras(_camera(stated.colour), _camera(stated.depth), motion)
            self._encoding, self._invalid = stated.encoding, stated.depth_invalid
        colours, depths = _images(path, _COLOUR, _COLOUR_SUFFIXES), _images(path, _DEPTH, _DEPTH_SUFFIXES)
        self.frames = {key: (colours[key], depths[key]) for key in sorted(colours.keys() & depths.keys())}
        if unmatched := len(colours.keys() ^ depths.keys()):
            self.notes = (f"{counted(unmatched, 'image')} left out: no matching image of the same name.",)
        if not self.frames:
            folders = "folders of these names with files of the same names"
            raise InputError(f"{path} has no pair: put colour.* and depth.* into it, or {folders}.")

    @classmethod
    def fits(cls, path: Path) -> bool:
        file = path / CALIBRATION_NAME
        if (path / META_NAME).is_file() or not file.is_file():
            return False
        try:
            is_small = file.stat().st_size <= _MAX_CALIBRATION_BYTES
            return is_small and b'"depth_to_colour"' in read_file(file).data.tobytes()
        except (OSError, InputError):  # opening it raises the precise error
            return True

    @classmethod
    def state(cls, path: Path) -> tuple[int, ...]:
        return *super().state(path), *super().state(path / CALIBRATION_NAME)

    def frame(self, key: str) -> RecordedFrame:
        colour, depth = map(read_file, self.at(key))
        return RecordedFrame(
            read_colour(colour),
            read_depth_values(depth, packed_channels(self._encoding)),
            colour.sha256,
            sha256_of(depth.data.tobytes(), self._calibration.data.tobytes()),  # the registered depth depends on both
            self._encoding,
            self._invalid,
        )

    def cameras(self, key: str) -> Cameras:
        return self._cameras


def _camera(stated: _Lens) -> Camera:
    facts = {"K": stated.K, "distortion": stated.distortion, "model": stated.model}
    return replace(lens_of(facts), size=stated.size)


def _images(root: Path, names: tuple[str, ...], suffixes: tuple[str, ...]) -> dict[str, Path]:
    """Images by key: those of the first folder that exists, or else the file of that name."""
    folder = next((root / name for name in names if (root / name).is_dir()), None)
    with os.scandir(folder or root) as entries:
        files = [Path(entry.path) for entry in entries if entry.is_file()]
    known = (file for file in files if file.suffix.lower() in suffixes)
    images = by_stem(file for file in known if folder is not None or file.stem in names)
    if folder is not None:
        return images
    return next(({_SINGLE_KEY: images[name]} for name in names if name in images), {})
