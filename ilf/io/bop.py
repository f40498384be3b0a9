"""Cameras of BOP scenes: scene_camera.json gives every image intrinsics and a depth scale of its own."""

from __future__ import annotations

import math
import os
from pathlib import Path

from ..camera import CameraIntrinsics, camera_from_numbers
from ..errors import FormatError, InputError
from ..sections import Section
from .files import read_json

CAMERA_FILE = "scene_camera.json"


def read_cameras(path: Path) -> dict[int, tuple[CameraIntrinsics, float]]:
    """Number of every image of a scene -> its intrinsics, and the millimetres that one unit of its depth is.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is damaged or holds something else.
    """
    data = read_json(path)
    if not isinstance(data, dict):
        raise FormatError(f"{path} must hold a JSON object with cam_K and depth_scale for each image.")
    cameras = {}
    for key, values in data.items():
        try:
            if not isinstance(values, dict):
                raise FormatError("It is no JSON object.")
            entry = Section(f"entry {key}", values)
            scale = entry.get("depth_scale", float)
            if not (scale > 0 and math.isfinite(1000 / scale)):
                raise FormatError(f"depth_scale must be positive millimetres, not {scale:g}.")
            cameras[int(key)] = camera_from_numbers(entry.items("cam_K", float), ""), scale
        except (InputError, ValueError) as error:
            raise FormatError(f"{path}, entry {key!r:.40}: {error}") from error
    return cameras


def camera_of_image(depth: Path) -> tuple[CameraIntrinsics, float]:
    """Intrinsics and depth scale of a depth file of a scene, by the number that is its name.

    Raises
    ------
    InputError
        If there is no scene_camera.json above its folder, or it has no entry for the file.
    FormatError
        As `read_cameras`.
    """
    path = depth.absolute().parent.parent / CAMERA_FILE
    if not os.path.isfile(path):
        raise InputError(f"{depth} is in no BOP scene: there is no {path}. Give its scale, as in bop:0.1.")
    cameras = read_cameras(path)
    if not depth.stem.isdecimal() or int(depth.stem) not in cameras:
        raise InputError(f"{path} has no entry for {depth.name}. Give its scale, as in bop:0.1.")
    return cameras[int(depth.stem)]
