"""Camera intrinsics: presets of common depth cameras, and the many ways in which people hold theirs."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .frame import CameraIntrinsics

IntrinsicsSpec = CameraIntrinsics | str | os.PathLike[str] | Sequence[float] | Mapping[str, Any] | NDArray[Any]

_WAY_OUT = "Give intrinsics as fx,fy,cx,cy, as one of the presets, or as a JSON file."

# name -> fx, fy, cx, cy and the (width, height) that they are for
_PUBLISHED: dict[str, tuple[float, float, float, float, tuple[int, int]]] = {
    # colour camera of NYU Depth V2 (toolbox, camera_params.m), onto which its depth is registered
    "nyu-kinect-v1": (518.8579, 519.4696, 325.5824, 253.7362, (640, 480)),
    # infrared camera, as libfreenect2 reads it from a typical device
    "kinect-v2": (365.456, 365.456, 254.878, 205.395, (512, 424)),
    # depth aligned to colour, as RGB-D frames have it: nominal, from the colour camera's field of view (69.4 degrees
    # at 16:9, of which 4:3 keeps the middle)
    "realsense-d435": (616.1, 616.1, 319.5, 239.5, (640, 480)),
    # native depth stream of a factory-calibrated device, for depth that is not aligned to colour
    "realsense-d435-depth": (385.134, 385.134, 321.635, 241.618, (640, 480)),
    # colour camera of the freiburg1 sequences
    "tum-fr1": (517.3, 516.5, 318.6, 255.3, (640, 480)),
    # depth camera of a factory-calibrated device, mode NFOV unbinned
    "azure-kinect": (503.9276, 503.9787, 332.0643, 325.8806, (640, 576)),
}

INTRINSICS: dict[str, CameraIntrinsics] = {
    name: CameraIntrinsics(*numbers[:4], name=name) for name, numbers in _PUBLISHED.items()
}
"""Preset name -> intrinsics, at the image size of `IMAGE_SIZES`."""

IMAGE_SIZES: dict[str, tuple[int, int]] = {name: numbers[4] for name, numbers in _PUBLISHED.items()}
"""Preset name -> (width, height) in pixels that the numbers are for."""


def intrinsics_from(spec: IntrinsicsSpec | None, shape: tuple[int, int] | None = None) -> CameraIntrinsics | None:
    """Intrinsics from whatever describes them.

    Parameters
    ----------
    spec : None, CameraIntrinsics, str, path, sequence, mapping or ndarray
        A preset name (see `INTRINSICS`); four numbers fx, fy, cx, cy [px], also as text "fx,fy,cx,cy";
        a row-major 3 x 3 matrix; {fx, fy, cx, cy}; {"K": four numbers or a 3 x 3 matrix};
        {"intrinsic_matrix": nine numbers, column-major} as Open3D writes it; or the path of a JSON file that
        holds one of these.
    shape : (int, int), optional
        (H, W) of the frame. Numbers whose own image size is known (presets; mappings with "width" and
        "height") are scaled to it.

    Returns
    -------
    CameraIntrinsics or None
        None only where `spec` is None.

    Raises
    ------
    InputError
        If there is no such preset, the numbers make no camera, or their image size has another aspect ratio
        than the frame.
    FormatError
        If the JSON file cannot be read.
    """
    if spec is None or isinstance(spec, CameraIntrinsics):
        return spec
    if isinstance(spec, str) and spec.strip().lower() in INTRINSICS:
        name = spec.strip().lower()
        return _fitted(INTRINSICS[name], IMAGE_SIZES[name], shape)
    if isinstance(spec, str) and "," in spec and not Path(spec).exists():
        return _from_text(spec)
    if isinstance(spec, str | os.PathLike):
        return _from_file(Path(spec), shape)
    return _from_data(spec, shape, name="")


def _from_text(text: str) -> CameraIntrinsics:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"{text!r} is not a list of numbers. {_WAY_OUT}") from error
    return _from_numbers(numbers, name="")


def _from_file(path: Path, shape: tuple[int, int] | None) -> CameraIntrinsics:
    if path.suffix != ".json" and len(path.parts) < 2 and not path.exists():
        near = difflib.get_close_matches(str(path).lower(), INTRINSICS, 1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise InputError(
            f"There is no intrinsics preset {str(path)!r}. {hint}Known: {', '.join(INTRINSICS)}. {_WAY_OUT}"
        )
    from .io.files import read_json  # here, because ilf.io itself imports this module

    data = read_json(path)
    try:
        return _from_data(data, shape, name=path.name)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _from_data(data: Any, shape: tuple[int, int] | None, name: str) -> CameraIntrinsics:
    """From parsed JSON, or from what a caller of the library holds in its place."""
    if not isinstance(data, Mapping):
        return _from_numbers(data, name)
    if "intrinsic_matrix" in data:
        matrix = _array(data["intrinsic_matrix"])
        found = _from_numbers(matrix.reshape(3, 3).T if matrix.shape == (9,) else matrix, name)
    elif "K" in data:
        found = _from_numbers(data["K"], name)
    else:
        missing = [key for key in ("fx", "fy", "cx", "cy") if key not in data]
        if missing:
            raise InputError(
                f"Intrinsics lack {', '.join(missing)}. Give fx, fy, cx and cy, or K, or intrinsic_matrix."
            )
        found = _from_numbers([data[key] for key in ("fx", "fy", "cx", "cy")], name)
    if "width" not in data or "height" not in data:
        return found
    size = _array([data["width"], data["height"]])
    if size.shape != (2,) or not (np.isfinite(size).all() and (size >= 1).all()):
        raise InputError("The width and height that belong to the intrinsics must be positive whole numbers.")
    return _fitted(found, (int(size[0]), int(size[1])), shape)


def _from_numbers(numbers: Any, name: str) -> CameraIntrinsics:
    array = _array(numbers).astype(float)
    if array.shape == (4,):
        fx, fy, cx, cy = array.tolist()
    elif array.shape in {(9,), (3, 3)}:
        (fx, skew, cx), (below, fy, cy), last = array.reshape(3, 3).tolist()
        if skew or below or last != [0, 0, 1]:
            raise InputError(
                "A camera matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], row by row and without skew. "
                + _WAY_OUT
            )
    else:
        raise InputError(f"Intrinsics must be four numbers or a 3 x 3 matrix, not {array.size} numbers. {_WAY_OUT}")
    return CameraIntrinsics(fx, fy, cx, cy, name)


def _array(numbers: Any) -> NDArray[Any]:
    try:
        array = np.asarray(numbers)
    except ValueError as error:
        raise InputError(f"Intrinsics must be plain numbers. {_WAY_OUT}") from error
    if array.dtype.kind not in "iuf":
        raise InputError(f"Intrinsics must be plain numbers, not {numbers!r:.60}. {_WAY_OUT}")
    return array


def _fitted(intrinsics: CameraIntrinsics, size: tuple[int, int], shape: tuple[int, int] | None) -> CameraIntrinsics:
    """Intrinsics for `size` (width, height), scaled to a frame of `shape` (H, W)."""
    if shape is None or size == (shape[1], shape[0]):
        return intrinsics
    scale = shape[1] / size[0]
    if not math.isclose(shape[0], scale * size[1], abs_tol=1.0):
        raise InputError(
            f"The intrinsics {intrinsics.name or 'given'} are for {size[0]} x {size[1]} pixels and cannot "
            f"be scaled to a frame of {shape[1]} x {shape[0]}, which has another aspect ratio. "
            "Give the frame's own numbers as fx,fy,cx,cy."
        )
    # the principal point is measured from the centre of a pixel, the image scales about a pixel's corner
    return CameraIntrinsics(
        intrinsics.fx * scale,
        intrinsics.fy * scale,
        (intrinsics.cx + 0.5) * scale - 0.5,
        (intrinsics.cy + 0.5) * scale - 0.5,
        intrinsics.name,
    )
