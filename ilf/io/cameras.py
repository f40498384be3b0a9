"""Camera intrinsics in many forms: presets, text, numbers, files; and files with them for other programs."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import cv2
import msgspec
import numpy as np
import yaml
from numpy.typing import NDArray

from .._runtime.files import read_file, read_json
from .._runtime.schema import converted
from ..data.camera import (
    DISTORTION_NOTE,
    FISHEYE,
    FISHEYE_NOTE,
    INTRINSICS,
    REMEDY,
    Camera,
    as_camera,
    camera_from_numbers,
    camera_of,
    fitted,
    is_normalised,
    is_preset,
    lens_of,
    lens_problem,
    stated_size,
)
from ..errors import FormatError, InputError, did_you_mean, told_as
from .camera_files import CAMERA_FILES, ENTRY_MARK, chosen_camera, read_camera_file
from .camera_places import PLACE_FACTS, depth_to_colour

IntrinsicsSpec = Camera | str | os.PathLike[str] | Sequence[float] | Mapping[str, Any] | NDArray[Any]


def intrinsics_from(spec: IntrinsicsSpec | None, shape: tuple[int, int] | None = None) -> Camera | None:
    """Convert any description of intrinsics to intrinsics.

    Parameters
    ----------
    spec : None, Camera, str, path, sequence, mapping or ndarray
        A preset name (see `INTRINSICS`); four numbers fx, fy, cx, cy [px], also as text "fx,fy,cx,cy", which may be
        followed by the width and height of the image that they are for; a 3 x 3 matrix, row by row or column by column;
        {fx, fy, cx, cy}; {"K": four numbers or a 3 x 3 matrix}, also as "intrinsic_matrix"; or the path of a file, see
        `read_camera_file`, followed by #NAME for one of its cameras.
    shape : (int, int), optional
        (H, W) of the frame. Numbers with a known image size (presets; mappings with "width" and "height") are
        scaled to it.

    Returns
    -------
    Camera or None
        None only if `spec` is None.

    Raises
    ------
    InputError
        If there is no such preset, the numbers are not valid intrinsics, their image size has another aspect
        ratio than the frame, their lens is a fisheye or of a model that is not supported, or a file has
        several cameras.
    FormatError
        If the file cannot be read.

    Examples
    --------
    >>> intrinsics_from("525,525,319.5,239.5").cx
    319.5
    >>> intrinsics_from("kinect-v2", shape=(212, 256)).fx
    182.728
    """
    return None if spec is None else as_camera(_stated(spec), shape)


def sized_camera(spec: IntrinsicsSpec) -> Camera:
    """The same with the size of the image that they are for, if it is stated, and not scaled."""
    camera = camera_of(_stated(spec), None)
    return replace(camera.pinhole, size=camera.size)


def frame_camera(spec: IntrinsicsSpec | None, shape: tuple[int, int] | None) -> tuple[Camera | None, tuple[str, ...]]:
    """The camera of a frame (H, W), as `intrinsics_from`, and notes on its lens and on scaling, a sentence or two each.

    It is None, with a note, if it is no pinhole camera; and if its angle of view alone is known, but not `shape`.
    """
    if spec is None:
        return None, ()
    stated = _stated(spec)
    if isinstance(stated, Mapping):
        if problem := lens_problem(stated):
            return None, (f"{stated.get('name') or 'Intrinsics'}: {problem}",)
        if shape is None and "angle_x" in stated and stated_size(stated) is None:
            return None, ()
    place = f"{stated['name']}: " if isinstance(stated, Mapping) and stated.get("name") else ""
    with told_as(InputError, f"{place}{{error}}", InputError):
        camera = camera_of(stated, shape)
    if camera.model == FISHEYE:
        return None, (f"{camera.name or 'Intrinsics'}: {FISHEYE_NOTE}",)
    is_bent = any(stated.get("distortion", ()) if isinstance(stated, Mapping) else camera.distortion)
    notes = (DISTORTION_NOTE,) if is_bent else ()
    return fitted(camera, shape).pinhole, _scaling_note(camera, shape) + notes


def lens_from(spec: IntrinsicsSpec, shape: tuple[int, int]) -> tuple[Camera, tuple[str, ...]]:
    """The camera of an image (H, W) with its distortion, from the same descriptions, and a note if it is scaled; raises
    as `intrinsics_from`, and InputError for distortion that OpenCV's models do not have."""
    stated = _stated(spec)
    camera = lens_of(stated, shape) if isinstance(stated, Mapping) else camera_of(stated, shape)
    return replace(fitted(camera, shape), size=(shape[1], shape[0])), _scaling_note(camera, shape)


def _scaling_note(camera: Camera, shape: tuple[int, int] | None) -> tuple[str, ...]:
    size = camera.size
    if size is None or shape in {None, size[::-1]} or is_normalised(camera):
        return ()
    name = camera.name or "given"
    return (f"The intrinsics {name} are for {size[0]} x {size[1]} pixels, and are scaled to the image.",)


def _stated(spec: IntrinsicsSpec) -> Any:
    """Intrinsics as `as_camera` takes them, with those of a file read."""
    if isinstance(spec, Mapping):
        known = {name: spec[name] for name in PLACE_FACTS if name in spec}  # of a file that has been read
        return chosen_camera(spec, "The mapping of intrinsics") | {"name": spec.get("name", "")} | known
    if isinstance(spec, os.PathLike) or (isinstance(spec, str) and not is_preset(spec)):
        is_text = isinstance(spec, str) and "," in spec and not os.path.exists(spec)
        return spec if is_text else _from_file(os.fspath(spec))
    return spec


_NUMBERS = re.compile(r"[-+\d.,eE\s]*,[-+\d.,eE\s]*")


def is_numbers(text: str) -> bool:
    """Whether a text states intrinsics by numbers, not by the name of a file or a preset."""
    return _NUMBERS.fullmatch(text) is not None


def _split(text: str) -> tuple[str, str]:
    """The file and the name of the camera in FILE or FILE#NAME."""
    file, _, entry = text.rpartition(ENTRY_MARK)
    return (text, "") if not file or os.path.exists(text) else (file, entry)


def _from_file(text: str) -> dict[str, Any]:
    """The camera of a file, or of FILE#NAME."""
    file, entry = _split(text)
    path = Path(file)
    if path.suffix not in CAMERA_FILES and len(path.parts) < 2 and not os.path.exists(path):
        hint = did_you_mean(file.lower(), INTRINSICS)
        raise InputError(f"There is no intrinsics preset {file!r}.{hint} Known: {', '.join(INTRINSICS)}. {REMEDY}")
    return read_camera_file(path, entry)


_PLACES = re.compile(rb"extrinsic|translation|\bT_c|\bRt\b", re.IGNORECASE)
"""What files of DepthAI, RealSense, Azure Kinect, Kalibr and ORB-SLAM call the places of cameras."""


def depth_place(
    colour: IntrinsicsSpec | None, depth: IntrinsicsSpec | None
) -> tuple[NDArray[np.float64], bool, tuple[str, ...]]:
    """Where the depth camera is, by what the descriptions of both cameras state.

    Returns
    -------
    motion : ndarray of float64, shape (4, 4)
        Transform of points [m] from the depth camera to the colour camera; the identity if it is not stated.
    is_rectified : bool
        Whether its images are rectified by that camera's own calibration, and so have no distortion.
    doubts : tuple of str
        That the file of its camera states places that are not used.
    """
    stated = (None if spec is None else _stated(spec) for spec in (colour, depth))
    of_colour, of_depth = (one if isinstance(one, Mapping) else {} for one in stated)
    motion = depth_to_colour(of_colour, of_depth)
    if motion is not None:
        return motion, "depth_place" in of_depth, ()
    file = Path(_split(os.fspath(depth))[0]) if isinstance(depth, str | os.PathLike) else None
    if file is None or not file.is_file() or not _PLACES.search(read_file(file).data.tobytes()):
        return np.eye(4), False, ()
    told = f"{file} also states where the cameras are, but depth is registered as if they were in one place"
    remedy = "If its edges lie beside those of colour, name both cameras in that file, or record aligned depth."
    return np.eye(4), False, (f"{told}. {remedy}",)


# Cameras of BOP scenes: scene_camera.json contains intrinsics and a depth scale for every image.

CAMERA_FILE = "scene_camera.json"


class _SceneCamera(msgspec.Struct):
    """The camera of an image, and millimetres per unit of its depth."""

    cam_K: list[float]
    depth_scale: Annotated[float, msgspec.Meta(gt=1e-300)]


def read_cameras(path: Path) -> dict[int, tuple[Camera, float]]:
    """Read the cameras of a scene: number of the image -> intrinsics, and millimetres per unit of its depth.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it is damaged or contains something else.
    """
    cameras = {}
    for key, stated in converted(read_json(path), dict[str, _SceneCamera], f"file {path}").items():
        with told_as(FormatError, f"{path}, entry {key!r:.40}: {{error}}", (InputError, ValueError)):
            cameras[int(key)] = camera_from_numbers(stated.cam_K, ""), stated.depth_scale
    return cameras


def camera_of_image(depth: Path) -> tuple[Camera, float]:
    """Return intrinsics and depth scale of a depth file of a scene, whose name is the image number.

    Raises
    ------
    InputError
        If there is no scene_camera.json in the parent of its folder, or it has no entry for the file.
    FormatError
        As `read_cameras`.
    """
    path = depth.absolute().parent.parent / CAMERA_FILE
    if not os.path.isfile(path):
        raise InputError(f"{depth} is not in a BOP scene: {path} does not exist. Give its scale, as in bop:0.1.")
    cameras = read_cameras(path)
    if not depth.stem.isdecimal() or int(depth.stem) not in cameras:
        raise InputError(f"{path} has no entry for {depth.name}. Give its scale, as in bop:0.1.")
    return cameras[int(depth.stem)]


# Files with the camera of an image, for other programs; `--intrinsics` reads them, too.


def camera_json(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) as JSON: by names, and as Open3D reads it."""
    columns = [camera.fx, 0.0, 0.0, 0.0, camera.fy, 0.0, camera.cx, camera.cy, 1.0]
    numbers = dict(zip(("fx", "fy", "cx", "cy"), camera.numbers, strict=True))
    content = {"width": shape[1], "height": shape[0], **numbers, "intrinsic_matrix": columns}
    return f"{json.dumps(content, indent=1)}\n".encode()


def opencv_yaml(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) for OpenCV's FileStorage, with the names of its calibration program."""
    storage = cv2.FileStorage(".yaml", cv2.FileStorage_WRITE | cv2.FileStorage_MEMORY)
    storage.write("image_width", shape[1])
    storage.write("image_height", shape[0])
    storage.write("camera_matrix", camera.matrix)
    storage.write("distortion_coefficients", np.zeros((1, 5)))
    return str(storage.releaseAndGetString()).encode()


def camera_info_yaml(camera: Camera, shape: tuple[int, int]) -> bytes:
    """The camera of images (H, W) as ROS's camera_info_manager reads it."""

    def matrix(values: np.ndarray) -> dict[str, object]:
        return {"rows": values.shape[0], "cols": values.shape[1], "data": values.ravel().tolist()}

    content = {
        "image_width": shape[1],
        "image_height": shape[0],
        "camera_name": "camera",
        "camera_matrix": matrix(camera.matrix),
        "distortion_model": "plumb_bob",
        "distortion_coefficients": matrix(np.zeros((1, 5))),
        "rectification_matrix": matrix(np.eye(3)),
        "projection_matrix": matrix(np.column_stack((camera.matrix, np.zeros(3)))),
    }
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None).encode()
