"""Reading camera intrinsics in many forms: presets, text, numbers, JSON files."""

from __future__ import annotations

import difflib
import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from .._runtime.files import FileContent, read_file, read_json
from .._runtime.schema import Section
from ..data.camera import INTRINSICS, REMEDY, CameraIntrinsics, as_camera, camera_from_numbers, camera_of, is_preset
from ..errors import FormatError, InputError
from .float_images import read_npy

IntrinsicsSpec = CameraIntrinsics | str | os.PathLike[str] | Sequence[float] | Mapping[str, Any] | NDArray[Any]


def intrinsics_from(spec: IntrinsicsSpec | None, shape: tuple[int, int] | None = None) -> CameraIntrinsics | None:
    """Convert any description of intrinsics to intrinsics.

    Parameters
    ----------
    spec : None, CameraIntrinsics, str, path, sequence, mapping or ndarray
        A preset name (see `INTRINSICS`); four numbers fx, fy, cx, cy [px], also as text "fx,fy,cx,cy";
        a row-major 3 x 3 matrix; {fx, fy, cx, cy}; {"K": four numbers or a 3 x 3 matrix};
        {"intrinsic_matrix": nine numbers, column-major} as written by Open3D; or the path of a file, see
        `read_camera_file`.
    shape : (int, int), optional
        (H, W) of the frame. Numbers with a known image size (presets; mappings with "width" and "height") are
        scaled to it.

    Returns
    -------
    CameraIntrinsics or None
        None only if `spec` is None.

    Raises
    ------
    InputError
        If there is no such preset, the numbers are not valid intrinsics, or their image size has another aspect
        ratio than the frame.
    FormatError
        If the file cannot be read.

    Examples
    --------
    >>> intrinsics_from("525,525,319.5,239.5").cx
    319.5
    >>> intrinsics_from("kinect-v2", shape=(212, 256)).fx
    182.728
    """
    if spec is None:
        return None
    if isinstance(spec, os.PathLike) or (isinstance(spec, str) and not is_preset(spec)):
        is_text = isinstance(spec, str) and "," in spec and not os.path.exists(spec)
        return _from_text(str(spec)) if is_text else _from_file(Path(spec), shape)
    return as_camera(spec, shape)


def _from_text(text: str) -> CameraIntrinsics:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"{text!r} is not a list of numbers. {REMEDY}") from error
    return camera_from_numbers(numbers, name="")


def _from_file(path: Path, shape: tuple[int, int] | None) -> CameraIntrinsics:
    if path.suffix not in _CAMERA_FILES and len(path.parts) < 2 and not os.path.exists(path):
        near = difflib.get_close_matches(str(path).lower(), INTRINSICS, 1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise InputError(f"There is no intrinsics preset {str(path)!r}. {hint}Known: {', '.join(INTRINSICS)}. {REMEDY}")
    data = read_camera_file(path)
    try:
        return camera_of(data, shape, name=path.name)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


# Files with the intrinsics of one camera, in the forms that data sets and recorders write.

_CAMERA_FILES = ".json", ".txt", ".yaml", ".yml", ".npy", ".xml"
_NAMES = {
    "fl_x": "fx", "fl_y": "fy", "focal_length_x": "fx", "focal_length_y": "fy", "principal_point_x": "cx",
    "principal_point_y": "cy", "ppx": "cx", "ppy": "cy", "w": "width", "h": "height", "xres": "width", "yres": "height",
}  # fmt: skip
"""Other names of the numbers of a camera -> those of `camera_of`."""
_KNOWN_NAMES = {*_NAMES, *_NAMES.values(), "K", "intrinsic_matrix"}
_FIRST_PIXEL_AT_A_HALF = "fl_x"
"""A name used only by files whose principal point is measured from the corner of the top left pixel."""
_NAMED_NUMBERS = re.compile(r"^\s*([\w.]+)\s*[:=]\s*(\S.*)$|<(\w+)>\s*([^<>]+?)\s*</\3>", re.MULTILINE)


def read_camera_file(path: Path, entry: str = "") -> Any:
    """Read the intrinsics of a camera.

    Parameters
    ----------
    path : Path
        JSON; NPY with a camera matrix; or text: a camera matrix of 3 or 4 rows and columns, or 3 rows and 4 columns,
        whose numbers may be in one line; "width height fx fy cx cy ..." in one line; or lines "name: numbers", as in
        YAML. In JSON and text, names may be those of Open3D, nerfstudio, librealsense and PCL.
    entry : str
        The name of one of several matrices in a text file, or of an object in JSON.

    Returns
    -------
    object
        As `camera_of` takes it: a mapping or numbers.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it is damaged or contains no camera.
    """
    content = read_file(path)
    if path.suffix.lower() == ".json":
        return _object_of(content, read_json(content), entry)
    if path.suffix.lower() == ".npy":
        return _matrix(content, read_npy(content).ravel().tolist())
    text = content.data.tobytes().decode("utf-8", "replace")
    named = {(name or tag).lower(): value or inner for name, value, tag, inner in _NAMED_NUMBERS.findall(text)}
    if entry:
        if entry.lower() not in named:
            raise FormatError(f"{content} has no entry {entry!r:.40}.")
        return _matrix(content, _floats(content, named[entry.lower()]))
    if named:
        numbers = {name: _floats(content, value)[0] for name, value in named.items() if name in _KNOWN_NAMES}
        return _object_of(content, numbers, "")
    return _matrix(content, _floats(content, text))


def _object_of(content: FileContent, data: Any, entry: str) -> Any:
    """The object in JSON that `camera_of` takes, with its names."""
    if isinstance(data, Mapping) and (entry or isinstance(data.get("camera"), Mapping)):
        data = data.get(entry or "camera")
        if not isinstance(data, Mapping):
            raise FormatError(f"{content} has no object {entry!r:.40}.")
    if not isinstance(data, Mapping):
        return data
    return named_camera(data)


def named_camera(data: Mapping[str, Any]) -> dict[str, Any]:
    """Intrinsics with the names of `camera_of`, from those of other programs."""
    found = {_NAMES.get(name, name): value for name, value in data.items() if name in _KNOWN_NAMES}
    if _FIRST_PIXEL_AT_A_HALF in data:
        found |= {name: found[name] - 0.5 for name in ("cx", "cy") if isinstance(found.get(name), int | float)}
        found.setdefault("fy", found["fx"])
    return found


_SIZE_AND_LENS = 11
"""Numbers in a file of Matterport3D: width, height, fx, fy, cx, cy and five of the lens distortion."""


def _floats(content: FileContent, text: str) -> list[float]:
    try:
        return [float(word) for word in re.split(r"[\s,;\[\]]+", text.strip("[]; \n\r\t")) if word]
    except ValueError as error:
        raise FormatError(f"{content} must contain the numbers of a camera matrix ({error!s:.80}).") from error


def _matrix(content: FileContent, numbers: list[float]) -> Any:
    """The 3 x 3 camera matrix in the numbers of a matrix, or a mapping of the numbers after an image size."""
    if len(numbers) == _SIZE_AND_LENS:
        return dict(zip(("width", "height", "fx", "fy", "cx", "cy"), numbers, strict=False))
    columns = {4: 0, 9: 3, 12: 4, 16: 4}.get(len(numbers))
    if columns is None:
        raise FormatError(
            f"{content} must contain a camera matrix (9, 12 or 16 numbers) or fx fy cx cy, not {len(numbers)} numbers."
        )
    if not columns:
        return numbers
    rows = [numbers[columns * row : columns * row + 3] for row in range(3)]
    return [number for row in rows for number in row]


# Cameras of BOP scenes: scene_camera.json contains intrinsics and a depth scale for every image.

CAMERA_FILE = "scene_camera.json"


def read_cameras(path: Path) -> dict[int, tuple[CameraIntrinsics, float]]:
    """Read the cameras of a scene: number of the image -> intrinsics, and millimetres per unit of its depth.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If it is damaged or contains something else.
    """
    data = read_json(path)
    if not isinstance(data, dict):
        raise FormatError(f"{path} must contain a JSON object with cam_K and depth_scale for each image.")
    cameras = {}
    for key, values in data.items():
        try:
            if not isinstance(values, dict):
                raise FormatError("it must be a JSON object.")
            entry = Section(f"entry {key}", values)
            scale = entry.get("depth_scale", float)
            if not (scale > 0 and math.isfinite(1000 / scale)):
                raise FormatError(f"depth_scale must be positive millimetres, not {scale:g}.")
            cameras[int(key)] = camera_from_numbers(entry.items("cam_K", float), ""), scale
        except (InputError, ValueError) as error:
            raise FormatError(f"{path}, entry {key!r:.40}: {error}") from error
    return cameras


def camera_of_image(depth: Path) -> tuple[CameraIntrinsics, float]:
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
