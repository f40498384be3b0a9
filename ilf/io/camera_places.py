"""Where the cameras of a file are: the transforms that programs of calibration write beside the intrinsics."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.camera import checked_transform, rigid_transform
from ..errors import InputError

PLACE_FACTS = "place", "depth_place", "rig", "depth_to_colour"
"""What a camera may state about its place, see `places_of`."""

Link = tuple[NDArray[np.float64], str]
"""A transform of points [m] from a camera to another frame, and the name of that frame."""

_LENGTHS = {0: 1.0, 1: 0.01, 2: 0.001, 3: 0.0254, 4: 0.3048}
"""Metres per unit of length, by DepthAI's number of the unit."""
_CENTIMETRES = 1
_DEPTH_TO_COLOUR = re.compile(r"^(extrinsics?|transform|t)?(depthtocolou?r|depth2colou?r|d2c|colou?rfromdepth)$")
"""Keys, in lower case and without punctuation, of the transform from the depth to the colour camera."""
_MAX_DEPTH, _FARTHEST = 20, 1000.0
"""Levels of a file, and metres between its cameras, beyond which nothing is used."""


def socket_name(socket: int) -> str:
    """The name of a camera of DepthAI by its number."""
    return f"CAM_{chr(ord('A') + socket)}"


def link_of(camera: Mapping[str, Any], path: str) -> Link | None:
    """Where the mapping of a camera says that it is, relative to another one: Kalibr's transform from the camera before
    it in the chain, that of an inertial unit, or DepthAI's in centimetres to another socket. None if it does not."""
    extrinsics = camera.get("extrinsics")
    for key, is_to_camera, target in (
        ("T_cn_cnm1", True, re.sub(r"\d{1,4}$", lambda found: str(int(found[0]) - 1), path)),
        ("T_cam_imu", True, "imu"),
        ("T_imu_cam", False, "imu"),
    ):
        if (motion := _transform(camera.get(key))) is not None:
            return np.asarray(np.linalg.inv(motion) if is_to_camera else motion, float), target
    if not isinstance(extrinsics, Mapping):
        return None
    socket, unit = extrinsics.get("toCameraSocket"), extrinsics.get("lengthUnit", _CENTIMETRES)
    if not (isinstance(socket, int) and 0 <= socket < 26 and isinstance(unit, int) and unit in _LENGTHS):
        return None
    motion = _of_parts(extrinsics.get("rotationMatrix"), extrinsics.get("translation"), _LENGTHS[unit])
    return None if motion is None else (motion, f"{path[: path.rfind('/') + 1]}{socket_name(socket)}")


def places_of(name: str, links: Mapping[str, Link], tree: Any) -> dict[str, Any]:
    """What a file states about the place of a camera, for `depth_to_colour`.

    Parameters
    ----------
    name : str
    links : mapping
        Name of a camera -> where it is.
    tree : mapping or list
        The content of the file.

    Returns
    -------
    dict
        "place", the transform of points [m] from the camera to the frame "rig", as 16 numbers; "depth_place", the same
        for depth by stereo matching, which has the axes of the rectified image; or "depth_to_colour".
    """
    found: dict[str, Any] = {}
    if links:
        motion, end = np.eye(4), name
        for _ in links:
            if end in links:
                motion, end = links[end][0] @ motion, links[end][1]
        found = {"place": motion.ravel().tolist(), "rig": end}
        if (turn := _rectification(name, tree)) is not None:
            found["depth_place"] = (motion @ np.linalg.inv(turn)).ravel().tolist()
    direct = {tuple(motion.ravel().tolist()) for motion in _direct(tree)}
    return found | ({"depth_to_colour": list(direct.pop())} if len(direct) == 1 else {})


def depth_to_colour(colour: Mapping[str, Any], depth: Mapping[str, Any]) -> NDArray[np.float64] | None:
    """The transform of points [m] from the depth camera to the colour camera, (4, 4), by what `places_of` found for
    both; None if it is not stated."""
    if "depth_to_colour" in depth:
        return _transform(depth["depth_to_colour"])
    if "place" not in depth or "place" not in colour or colour.get("rig") != depth.get("rig"):
        return None
    place, of_depth = _transform(colour["place"]), _transform(depth.get("depth_place", depth["place"]))
    return None if place is None or of_depth is None else np.linalg.inv(place) @ of_depth


def _rectification(name: str, tree: Any) -> NDArray[np.float64] | None:
    """DepthAI's rotation from a camera of its stereo pair to the rectified image."""
    stereo = tree.get("stereoRectificationData") if isinstance(tree, Mapping) else None
    if not isinstance(stereo, Mapping):
        return None
    for side in ("left", "right"):
        socket = stereo.get(f"{side}CameraSocket")
        if isinstance(socket, int) and 0 <= socket < 26 and socket_name(socket) == name.rpartition("/")[2]:
            return _of_parts(stereo.get(f"rectifiedRotation{side.title()}"), [0.0] * 3)
    return None


def _direct(tree: Any, level: int = 0) -> Iterator[NDArray[np.float64]]:
    """The transforms from depth to colour in a tree, by the names of their keys."""
    for key, item in tree.items() if isinstance(tree, Mapping) and level < _MAX_DEPTH else ():
        if not _DEPTH_TO_COLOUR.match(re.sub(r"[\W_]", "", str(key)).lower()):
            yield from _direct(item, level + 1)
        elif (motion := _of_names(item) if isinstance(item, Mapping) else _transform(item)) is not None:
            yield motion


def _of_names(stated: Mapping[str, Any]) -> NDArray[np.float64] | None:
    """A transform of a rotation, in rows, and a translation; without a unit, it is in millimetres from 1 on, since no
    cameras of one device are metres apart. None if it is not clear: librealsense has nine numbers column by column,
    others have them row by row."""
    rotation = translation = None
    scale = 0.0
    for key, item in stated.items():
        plain = re.sub(r"[\W_]", "", str(key)).lower()
        if plain == "r" or plain.startswith("rot"):
            is_in_rows = isinstance(item, list) and all(isinstance(row, list) for row in item)
            rotation = item if is_in_rows or "rowmajor" in plain else None
        elif plain in {"t", "unit", "units"} or plain.startswith("trans"):
            told = str(item) if isinstance(item, str) else plain.removeprefix("translation")
            scale = next((size for name, size in (("mm", 0.001), ("mill", 0.001), ("cm", 0.01)) if name in told), scale)
            translation = item if isinstance(item, list | Mapping) else translation
    return _of_parts(rotation, translation, scale)


def _of_parts(rotation: Any, translation: Any, scale: float = 0.0) -> NDArray[np.float64] | None:
    """A transform of 3 x 3 numbers and three numbers or {x, y, z}, in units of `scale` metres; 0: see `_of_names`."""
    if isinstance(translation, Mapping):
        translation = [translation.get(axis) for axis in "xyz"]
    try:
        motion = rigid_transform(np.asarray(rotation, float), np.ravel(np.asarray(translation, float)))
    except (TypeError, ValueError, OverflowError):
        return None
    motion[:3, 3] *= scale or (1.0 if np.abs(motion[:3, 3]).max() < 1 else 0.001)
    return _transform(motion)


def _transform(matrix: Any) -> NDArray[np.float64] | None:
    """A transform of 4 x 4 numbers, or their mapping as OpenCV has it; None for anything else."""
    values = matrix.get("data") if isinstance(matrix, Mapping) else matrix
    try:
        motion = checked_transform(np.reshape(np.asarray(values, float), (4, 4)), "")
    except (TypeError, ValueError, OverflowError, InputError):
        return None
    return motion if np.abs(motion[:3, 3]).max() < _FARTHEST else None
