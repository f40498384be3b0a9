"""Data sets whose layout says how their frames are read: BOP, SUN RGB-D, 7-Scenes."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..camera import INTRINSICS, CameraIntrinsics, camera_from_numbers
from ..errors import FormatError, InputError
from .bop import CAMERA_FILE, read_cameras
from .files import read_file
from .frame_source import FrameSource
from .frames import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES

SEVEN_SCENES_NOTE = (
    "These look like frames of 7-Scenes: 65535 is read as missing, and depth is not registered to colour, so that "
    "edges of both may lie some pixels apart."
)
_SUN_CAMERA_FILE = "intrinsics.txt"
_SUN_FOLDERS = "image", "depth"
_SEVEN_SCENES_CAMERA = CameraIntrinsics(585.0, 585.0, 320.0, 240.0, "7-scenes")
_SEVEN_SCENES_NAME = re.compile(r"frame-\d{6}\.(color|depth)\.png$")
_BOP_COLOUR_FOLDERS = "rgb", "gray"


def stated(how: FrameSource, source: FrameSource) -> FrameSource:
    """A source with what the user has said of all frames in the place of what the data set says."""
    says_nothing = how.depth_units is None and how.encoding is None
    return replace(
        source,
        depth_units=source.depth_units if says_nothing else how.depth_units,
        encoding=source.encoding if says_nothing else how.encoding,
        invalid=source.invalid if how.invalid is None else how.invalid,
        min_confidence=source.min_confidence if how.min_confidence is None else how.min_confidence,
        intrinsics=source.intrinsics if how.intrinsics is None else how.intrinsics,
    )


def is_bop(files: Collection[str]) -> bool:
    """Whether a folder with these files is a scene of BOP."""
    return CAMERA_FILE in files


def bop_frames(root: str | Path) -> list[FrameSource]:
    """The frames of a BOP scene that have colour and depth, by number; each has intrinsics and a scale of its own."""
    cameras = read_cameras(Path(root) / CAMERA_FILE)
    colours = {
        int(path.stem): path
        for folder in reversed(_BOP_COLOUR_FOLDERS)
        for path in _files(Path(root) / folder, COLOUR_SUFFIXES)
        if path.stem.isdecimal()
    }
    return [
        FrameSource(str(colours[int(path.stem)]), str(path), 1000 / scale, camera)
        for path in _files(Path(root) / "depth", DEPTH_FILE_SUFFIXES)
        if path.stem.isdecimal() and int(path.stem) in colours
        for camera, scale in (cameras.get(int(path.stem), (None, None)),)
        if camera is not None and scale is not None
    ]


def is_sun(files: Collection[str], folders: Collection[str]) -> bool:
    """Whether a folder that holds these is a frame of SUN RGB-D."""
    return _SUN_CAMERA_FILE in files and set(_SUN_FOLDERS) <= set(folders)


def sun_frame(root: str | Path) -> FrameSource:
    """The frame of a folder of SUN RGB-D; InputError if it has not one colour and one depth file."""
    colours, depths = (
        _files(Path(root) / folder, suffixes)
        for folder, suffixes in zip(_SUN_FOLDERS, (COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES), strict=True)
    )
    if len(colours) != 1 or len(depths) != 1:
        raise InputError(
            f"{root} looks like a frame of SUN RGB-D, but has {len(colours)} colour and {len(depths)} depth files in "
            "place of one each."
        )
    path = Path(root) / _SUN_CAMERA_FILE
    try:
        numbers = np.array(read_file(path).data.tobytes().split(), float)
        camera = camera_from_numbers(numbers, "")
    except (ValueError, InputError) as error:
        raise FormatError(f"{path} must hold the nine numbers of a camera matrix ({error!s:.200}).") from error
    return FrameSource(str(colours[0]), str(depths[0]), None, camera, encoding="sun")


def is_seven_scenes(files: Collection[str]) -> bool:
    """Whether a folder with these files is a sequence of 7-Scenes."""
    return any(name.endswith(".pose.txt") for name in files) and any(map(_SEVEN_SCENES_NAME.match, files))


def of_seven_scenes(source: FrameSource) -> FrameSource:
    """The same files, read as 7-Scenes has them."""
    return replace(source, depth_units=1000.0, invalid=65535.0, intrinsics=_SEVEN_SCENES_CAMERA)


def camera_by_name(root: Path) -> CameraIntrinsics | None:
    """The published camera of a sequence of TUM or Bonn, by its folder's name; None for others."""
    name = root.name.lower()
    if number := re.search(r"freiburg([123])", name):
        return INTRINSICS[f"tum-fr{number[1]}"]
    return INTRINSICS["bonn"] if name.startswith("rgbd_bonn") else None


def _files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files with one of these endings, by name; none if there is no such folder."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries if not entry.name.startswith(".") and os.path.isfile(entry)]
    except OSError:
        return []
    return [folder / name for name in sorted(names) if Path(name).suffix.lower() in suffixes]
