"""Depth encodings: conversion of a depth file's values to metres, and values that mark missing depth."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data.camera import Camera, fitted
from ..data.frame import FARTHEST_DEPTH, FrameInputs
from ..errors import FormatError, InputError, ParameterError
from .cameras import camera_of_image
from .depth import checked_number, checked_units, default_depth_units, depth_in_metres

_FARTHEST_KINECT = 10.0
_BOP = "bop"
_DISPARITY = "disparity"
_RAY = "ray"

EncodingSpec = str | float
"""A name of `ENCODINGS`, "bop", "bop:SCALE", "disparity:FB", "ray:UNITS,FX,FY,CX,CY", or a number of file units per
metre."""


@dataclass(frozen=True)
class DepthEncoding:
    """Conversion of the values of a depth file to metres.

    Most files contain depth times a constant: these encodings are defined by `units` alone. All others have a name.

    Attributes
    ----------
    name : str or None
        None if `units` define the encoding.
    units : float
        File units per metre; for named encodings, of the decoded values, and 1 if these have no fixed steps.
    is_swapped : bool
        The two bytes of each value are swapped.
    is_rotated : bool
        The lowest three bits of each value are its highest, as in SUN RGB-D and SUN3D.
    is_disparity : bool
        Values are the raw disparity of a Kinect v1, with the constants of NYU Depth V2's toolbox.
    invalid : float or None
        The file's value that marks missing depth, besides zero, negative and non-finite values.
    focal_baseline : float or None
        Values are the disparity of a rectified stereo pair; this is its focal length times baseline, in the file's
        unit of disparity times metres: depth = this / value.
    ray : tuple of float or None
        Values are distances along the rays of a camera with these fx, fy, cx, cy [px]; then, if known, the width and
        height of the image that they apply to.
    """

    name: str | None
    units: float
    is_swapped: bool = False
    is_rotated: bool = False
    is_disparity: bool = False
    invalid: float | None = None
    focal_baseline: float | None = None
    ray: tuple[float, ...] | None = None

    @property
    def text(self) -> str:
        """Description for users."""
        way = (
            f"{self.units:g} units per metre"
            if self.name is None
            else f"{self.name}, {ENCODING_DESCRIPTIONS[_kind(self.name)]}"
        )
        return way if not self.invalid else f"{way}, {self.invalid:g} is missing"

    @property
    def farthest(self) -> float:
        """Maximum depth [m] that can be measured."""
        return _FARTHEST_KINECT if self.is_disparity else FARTHEST_DEPTH

    def metres(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Convert values of a file to depth [m], float32 of the same shape; NaN = missing.

        Raises
        ------
        FormatError
            If the encoding is one of 16-bit integers, and the values are of another type.
        """
        metres = self._decoded(values)
        if self.invalid is not None:
            with np.errstate(over="ignore"):  # in the type of the values, the number may overflow to infinity
                metres[values == self.invalid] = np.nan
        return metres

    def _decoded(self, values: NDArray[Any]) -> NDArray[np.float32]:
        if self.name is None:
            return depth_in_metres(values, self.units)
        if self.focal_baseline is not None:
            with np.errstate(all="ignore"):
                return depth_in_metres(self.focal_baseline / values.astype(np.float64), 1.0)
        if self.ray is not None:
            with np.errstate(all="ignore"):
                return depth_in_metres(values.astype(np.float64) / _ray_lengths(self.ray, values.shape), self.units)
        if values.dtype != np.uint16:
            raise FormatError(
                f"The encoding {self.name} applies to 16-bit integers, not to {values.dtype}. Give the encoding of "
                "this file."
            )
        if self.is_swapped:
            values = values.byteswap()
        if self.is_rotated:
            values = (values >> 3) | (values << 13)
        if not self.is_disparity:
            return depth_in_metres(values, self.units)
        with np.errstate(divide="ignore"):
            return depth_in_metres(351.3 / (1092.5 - values.astype(np.float64)), 1.0)


ENCODINGS: dict[str, DepthEncoding] = {
    "mm": DepthEncoding(None, 1000.0),
    "0.1mm": DepthEncoding(None, 10_000.0),
    "cm": DepthEncoding(None, 100.0),
    "m": DepthEncoding(None, 1.0),
    "tum": DepthEncoding(None, 5000.0),
    "matterport": DepthEncoding(None, 4000.0),
    "replica": DepthEncoding(None, 6553.5),
    "kitti": DepthEncoding(None, 256.0),
    "sun": DepthEncoding("sun", 1000.0, is_rotated=True),
    "nyu-raw": DepthEncoding("nyu-raw", 1.0, is_swapped=True, is_disparity=True),
    "kinect-raw": DepthEncoding("kinect-raw", 1.0, is_disparity=True),
    "mm-swapped": DepthEncoding("mm-swapped", 1000.0, is_swapped=True),
}
"""Name -> encoding. Besides these there are "bop", whose scale is read from the scene's scene_camera.json,
"disparity:FB" and "ray:UNITS,FX,FY,CX,CY"."""

ENCODING_DESCRIPTIONS: dict[str, str] = {
    "mm": "millimetres",
    "0.1mm": "tenths of a millimetre",
    "cm": "centimetres",
    "m": "metres",
    "tum": "5000 per metre (TUM, Bonn, ICL)",
    "matterport": "4000 per metre (Matterport3D)",
    "replica": "6553.5 per metre (Replica)",
    "kitti": "256 per metre (KITTI)",
    "sun": "millimetres with rotated bits (SUN RGB-D, SUN3D)",
    "nyu-raw": "disparity with swapped bytes (raw files of NYU Depth V2)",
    "kinect-raw": "disparity of a Kinect v1",
    "mm-swapped": "millimetres with swapped bytes",
    _BOP: "by the depth_scale in scene_camera.json (BOP)",
    _DISPARITY: "disparity:FB, disparity of a stereo pair, with focal length x baseline FB",
    _RAY: "ray:UNITS,FX,FY,CX,CY, distance along the rays of a camera, UNITS per metre",
}
"""Name -> description, for all names that `encoding_of` accepts."""


def encoding_of(spec: EncodingSpec, depth: Path | None = None) -> DepthEncoding:
    """Return the encoding given by a name or a number.

    Parameters
    ----------
    spec : str or float
        A name of `ENCODINGS`; a number of file units per metre, also as text; "bop:SCALE" for millimetres = value times
        SCALE; "bop", which reads the scale from the scene's scene_camera.json; "disparity:FB" for metres = FB / value,
        where FB is focal length [px] times baseline [m], times 256 if the file contains disparity times 256; or
        "ray:UNITS,FX,FY,CX,CY", optionally followed by ",WIDTH,HEIGHT", for distances along the rays of a camera.
    depth : Path, optional
        The depth file, for "bop".

    Raises
    ------
    ParameterError
        If it is unknown.
    InputError
        If it is "bop", and the file is not in such a scene.

    Examples
    --------
    >>> encoding_of("tum").units, encoding_of(4000).units, encoding_of("bop:0.1").units
    (5000.0, 4000.0, 10000.0)
    >>> encoding_of("sun").metres(np.array([[15024]], np.uint16))
    array([[1.878]], dtype=float32)
    """
    if not isinstance(spec, str):
        return DepthEncoding(None, checked_units(spec))
    name = spec.strip().lower()
    if name in ENCODINGS:
        return ENCODINGS[name]
    if needs_scene(name):
        return DepthEncoding(None, 1000 / _scale_beside(depth))
    if name == _DISPARITY:
        raise ParameterError(
            "Converting disparity to depth needs focal length [px] times baseline [m] of the stereo pair: give "
            "disparity:FB, such as disparity:52.5 for 525 px and 0.1 m."
        )
    try:
        if _kind(name) == _DISPARITY:
            product = checked_units(float(name.partition(":")[2]))
            return DepthEncoding(f"{_DISPARITY}:{product!r}", 1.0, focal_baseline=product)
        if _kind(name) == _RAY:
            return _along_rays(name)
        if name.startswith(f"{_BOP}:"):
            scale = checked_units(float(name.removeprefix(f"{_BOP}:")))
            return DepthEncoding(None, checked_units(1000 / scale))
        return DepthEncoding(None, checked_units(float(name)))
    except ValueError as error:
        near = difflib.get_close_matches(name, ENCODING_DESCRIPTIONS, 1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise ParameterError(
            f"There is no depth encoding {spec!r:.60}. {hint}Give one of {', '.join(ENCODING_DESCRIPTIONS)}, or "
            f"a number of file "
            "units per metre."
        ) from error


def ray_encoding(units: float, camera: Camera, size: tuple[int, int] | None = None) -> str:
    """The name of the encoding of distances along the rays of a camera.

    Parameters
    ----------
    units : float
        File units per metre.
    camera : Camera
    size : (int, int), optional
        Width and height [px] of the image that the intrinsics apply to; other images are scaled. None: any image.

    Examples
    --------
    >>> ray_encoding(1.0, Camera(3.0, 3.0, 0.0, 0.0))
    'ray:1.0,3.0,3.0,0.0,0.0'
    >>> encoding_of("ray:1,3,3,0,0").metres(np.full((1, 5), 5.0))[0, [0, 4]].tolist()
    [5.0, 3.0]
    """
    numbers = units, camera.fx, camera.fy, camera.cx, camera.cy, *(size or ())
    return f"{_RAY}:{','.join(repr(float(number)) for number in numbers)}"


def _along_rays(name: str) -> DepthEncoding:
    """The encoding of a name "ray:..."; raises ParameterError if its numbers are no camera."""
    units, *numbers = (float(number) for number in name.partition(":")[2].split(","))
    size = tuple(int(number) if number.is_integer() else 0 for number in numbers[4:])
    if len(numbers) not in {4, 6} or min(size, default=1) < 1:
        raise ParameterError(
            f"{name!r:.80} must be ray:UNITS,FX,FY,CX,CY, five numbers, or seven with the image's width and height."
        )
    try:
        camera = _camera(numbers)
    except InputError as error:
        raise ParameterError(f"{name!r:.80}: {error}") from error
    spec = ray_encoding(checked_units(units), camera, (size[0], size[1]) if size else None)
    return DepthEncoding(spec, units, ray=tuple(numbers))


def _ray_lengths(ray: tuple[float, ...], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """The length of the ray through each pixel (H, W) up to depth 1."""
    height, width = shape[:2]
    try:
        camera = fitted(_camera(ray), (height, width))
    except InputError as error:
        raise FormatError(str(error)) from error
    x, y = (np.arange(width) - camera.cx) / camera.fx, (np.arange(height) - camera.cy) / camera.fy
    return np.sqrt(1 + x**2 + y[:, None] ** 2)


def _camera(numbers: Sequence[float]) -> Camera:
    fx, fy, cx, cy, *size = numbers
    return Camera(fx, fy, cx, cy, size=(int(size[0]), int(size[1])) if size else None)


def needs_scene(spec: EncodingSpec) -> bool:
    """Whether it is "bop", which is defined only for a depth file in its scene."""
    return isinstance(spec, str) and spec.strip().lower() == _BOP


def is_name(spec: EncodingSpec | None) -> bool:
    """Whether it is the name of an encoding, not a number of units."""
    return isinstance(spec, str) and _kind(spec) in ENCODING_DESCRIPTIONS


def _kind(name: str) -> str:
    """Return a name without its number."""
    return name.strip().lower().partition(":")[0]


def chosen_encoding(
    values: NDArray[Any],
    depth: Path,
    given: EncodingSpec | None,
    stated: EncodingSpec | None,
    invalid: float | None,
) -> DepthEncoding:
    """Return the encoding of a file's values: the given one, else the one stated beside the file, else the default for
    their type (`default_depth_units`); raise as `encoding_of`, and ParameterError if `invalid` is not a number."""
    spec = next((spec for spec in (given, stated) if spec is not None), default_depth_units(values))
    return replace(encoding_of(spec, depth), invalid=None if invalid is None else checked_invalid(invalid))


def single_encoding(encoding: EncodingSpec | None, depth_units: float | None) -> EncodingSpec | None:
    """Return the encoding given by either argument; raise ParameterError if both are given."""
    if encoding is not None and depth_units is not None:
        raise ParameterError(
            f"Both a depth encoding ({encoding}) and depth units ({depth_units}) are given. Units per metre are also "
            "an encoding: give only one of them."
        )
    return encoding if depth_units is None else checked_units(depth_units)


def encoding_of_inputs(inputs: FrameInputs) -> DepthEncoding:
    """Return the encoding with which a frame's depth file was read."""
    spec = inputs.depth_units if inputs.encoding is None else inputs.encoding
    return replace(encoding_of(spec), invalid=inputs.invalid)


def checked_invalid(value: object) -> float:
    """Return a file's value for missing depth as float; raise ParameterError unless it is a finite number."""
    number = checked_number(value, "The invalid value must be a number")
    if not math.isfinite(number):
        raise ParameterError("The invalid value must be a finite number: non-finite values are always missing.")
    return number


def beyond_sensor_range(metres: NDArray[np.floating], farthest: float = FARTHEST_DEPTH) -> NDArray[np.bool_] | None:
    """Return pixels whose depth [m] no sensor can measure; None if there are none, or if the scale is likely wrong.

    The scale is likely wrong if most of the depth is that large and does not have a single value, like an invalid
    marker.
    """
    far = metres > farthest
    count = int(np.count_nonzero(far))
    if not count:
        return None
    values = metres[far]
    is_mark = count < np.count_nonzero(np.isfinite(metres)) and bool((values == values[0]).all())
    return far if is_mark or 2 * count < np.count_nonzero(np.isfinite(metres)) else None


def _scale_beside(depth: Path | None) -> float:
    if depth is None:
        raise ParameterError('"bop" needs the depth file of a scene; otherwise give "bop:SCALE".')
    return camera_of_image(depth)[1]
