"""Depth encodings: conversion of a depth file's values to metres, and values that mark missing depth."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import as_float
from ..data.camera import Camera, fitted
from ..data.frame import DEPTH_LIMITS, FARTHEST_DEPTH, FrameInputs
from ..errors import FormatError, InputError, ParameterError, did_you_mean, told_as
from .cameras import camera_of_image

UINT16_MAX = 65535
"""Maximum value of a 16-bit PNG."""

_FARTHEST_KINECT = 10.0
_BOP, _DISPARITY, _RAY, _ZBUFFER, _SHARE = "bop", "disparity", "ray", "zbuffer", "m/FAR"
_PACKED = {"rgb24": "rgb", "bgr24": "bgr", "float32": "bgra"}
"""Name of an encoding in several channels of 8 bits -> the channels, from the lowest bits of a value to the highest."""

_LARGEST_PACKED = 2**24 - 1

_ROUNDING = 1e-6
"""By how much shares in single precision may exceed 1."""

EncodingSpec = str | float
"""A name of `ENCODING_DESCRIPTIONS`, with its numbers, or a number of file units per metre."""


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
    decode : callable or None
        Converts the values of a file to depth in `units`; None if they are that.
    farthest : float
        Depth [m] beyond which values count as missing: the sensor's range, or a renderer's far plane.
    channels : str
        The channels that contain a value, from its lowest bits to its highest; "" for one channel.
    invalid : float or None
        The file's value that marks missing depth, besides zero, negative and non-finite values.
    """

    name: str | None
    units: float
    decode: Callable[[NDArray[Any]], NDArray[Any]] | None = field(default=None, compare=False)
    farthest: float = FARTHEST_DEPTH
    channels: str = ""
    invalid: float | None = None

    @property
    def text(self) -> str:
        """Description for users."""
        if self.name is None:
            way = f"{self.units:g} units per metre"
        else:
            kind = _kind(self.name)
            described = ENCODING_DESCRIPTIONS[kind]
            way = f"{self.name}, {described.partition(', ')[2] if kind in _WITH_NUMBERS else described}"
        return way if not self.invalid else f"{way}, {self.invalid:g} is missing"

    def metres(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Convert values of a file to depth [m], float32 of the same shape. Values that are not finite, or below
        `ilf.data.frame.DEPTH_LIMITS`, as zero but for rounding is, become NaN.

        Raises
        ------
        FormatError
            If the values are none of this encoding, such as floats in place of 16-bit integers.
        """
        with np.errstate(all="ignore"):
            depth = values if self.decode is None else self.decode(values)
            metres = (depth if self.units == 1 else depth.astype(np.float64) / self.units).astype(np.float32)
            metres[~(np.isfinite(metres) & (metres >= DEPTH_LIMITS[0]))] = np.nan
        if self.invalid is not None:
            with np.errstate(over="ignore"):  # in the type of the values, the number may overflow to infinity
                metres[values == self.invalid] = np.nan
        return metres


TUM_UNITS = 5000.0
"""Units per metre of depth in TUM's data sets."""

KINECT_DISPARITY = "nyu-raw", "kinect-raw"
"""Names of the encodings that have a value for missing depth."""

_Decoder = Callable[[NDArray[Any]], NDArray[Any]]

_FIXED: dict[str, tuple[float, _Decoder | None, str]] = {
    "mm": (1000.0, None, "millimetres"),
    "0.1mm": (10_000.0, None, "tenths of a millimetre"),
    "cm": (100.0, None, "centimetres"),
    "m": (1.0, None, "metres"),
    "tum": (TUM_UNITS, None, "5000 per metre (TUM, Bonn, ICL)"),
    "matterport": (4000.0, None, "4000 per metre (Matterport3D)"),
    "replica": (6553.5, None, "6553.5 per metre (Replica)"),
    "kitti": (256.0, None, "256 per metre (KITTI)"),
    "taskonomy": (512.0, None, "512 per metre (Taskonomy, 2D-3D-S)"),
    "sun": (1000.0, lambda v: (v >> 3) | (v << 13), "millimetres with rotated bits (SUN RGB-D, SUN3D)"),
    "nyu-raw": (1.0, lambda v: _of_kinect(v.byteswap()), "disparity with swapped bytes (raw files of NYU Depth V2)"),
    "kinect-raw": (1.0, lambda v: _of_kinect(v), "disparity of a Kinect v1"),
    "mm-swapped": (1000.0, lambda v: v.byteswap(), "millimetres with swapped bytes"),
    "depth16": (1000.0, lambda v: v & 0x1FFF, "millimetres below three bits of confidence (Android's DEPTH16)"),
    "float16": (1.0, lambda v: v.view(np.float16), "metres, half-precision floats as 16-bit integers (CO3D)"),
    "float32": (1.0, lambda v: v.view(np.float32), "metres, floats in four channels, lowest in blue (TartanAir V2)"),
}
"""Name -> units per metre; what decodes 16-bit integers, or the bits of `_PACKED` channels, to depth in them, None if
they are that; and description."""


def _of_kinect(values: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Depth [m] from raw disparity of a Kinect v1, with the constants of NYU Depth V2's toolbox."""
    return np.asarray(351.3 / (1092.5 - values.astype(np.float64)))


def _fixed(name: str, units: float, decode: _Decoder | None) -> DepthEncoding:
    if decode is None:
        return DepthEncoding(None, units)
    channels = _PACKED.get(name, "")
    kind, stored = (np.uint32, "four channels of 8 bits") if channels else (np.uint16, "16-bit integers")

    def checked(values: NDArray[Any]) -> NDArray[Any]:
        if values.dtype != kind:
            raise FormatError(f"This depth encoding applies to {stored}, not to {values.dtype}. Give another.")
        return decode(np.ascontiguousarray(values))

    farthest = _FARTHEST_KINECT if name in KINECT_DISPARITY else FARTHEST_DEPTH
    return DepthEncoding(name, units, checked, farthest, channels)


ENCODINGS = {name: _fixed(name, units, decode) for name, (units, decode, _) in _FIXED.items()}
"""Name -> encoding. `ENCODING_DESCRIPTIONS` also has those with numbers of their own."""


def encoding_of(spec: EncodingSpec, depth: Path | None = None) -> DepthEncoding:
    """Return the encoding given by a name or a number.

    Parameters
    ----------
    spec : str or float
        A name of `ENCODINGS`; a number of file units per metre, also as text; "bop:SCALE" for millimetres = value times
        SCALE; "bop", which reads the scale from the scene's scene_camera.json; "disparity:FB" for metres = FB / value,
        where FB is focal length [px] times baseline [m], times 256 if the file contains disparity times 256;
        "disparity:FB,OFFSET" for metres = FB / (value + OFFSET);
        "ray:UNITS,FX,FY,CX,CY", optionally followed by ",WIDTH,HEIGHT", for distances along the rays of a camera;
        "zbuffer:NEAR,FAR", optionally followed by ",reversed", for a z-buffer of OpenGL or Direct3D, as floats or
        16-bit integers; "m/FAR" or "m/NEAR,FAR" for shares of a depth or of a range, likewise; "rgb24:METRES" or
        "bgr24:METRES" for shares in the bits of three channels. The values of the far plane count as missing.
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
        if depth is None:
            raise ParameterError('"bop" needs the depth file of a scene; otherwise give "bop:SCALE".')
        return DepthEncoding(None, 1000 / camera_of_image(depth)[1])
    kind, numbers = _kind(name), re.split("[:/]", name, maxsplit=1)[-1]
    try:
        if kind in _WITH_NUMBERS:
            return _WITH_NUMBERS[kind][0](numbers)
        return DepthEncoding(None, checked_units(float(name)))
    except ValueError as error:
        if kind in _WITH_NUMBERS:
            raise ParameterError(f"{spec!r:.80} must be {ENCODING_DESCRIPTIONS[kind]}.") from error
        hint = did_you_mean(name, ENCODING_DESCRIPTIONS)
        known = f"{', '.join(ENCODING_DESCRIPTIONS)}, or a number of file units per metre"
        raise ParameterError(f"There is no depth encoding {spec!r:.60}.{hint} Give one of {known}.") from error


# Encodings with numbers of their own. What makes them raises ValueError if these are none.


def _by_disparity(text: str) -> DepthEncoding:
    """Disparity of a rectified stereo pair, whose principal points are an offset apart."""
    product, *offset = (float(number) for number in text.split(","))
    if len(offset) > 1 or not all(map(math.isfinite, offset)):
        raise ValueError
    name = ",".join(repr(number) for number in (checked_units(product), *offset))

    def decode(values: NDArray[Any]) -> NDArray[np.float64]:
        disparity = values.astype(np.float64)
        return np.asarray(product / np.where(disparity > 0, disparity + sum(offset), np.nan))

    return DepthEncoding(f"{_DISPARITY}:{name}", 1.0, decode)


def _by_planes(text: str) -> DepthEncoding:
    """A z-buffer of 0 at the near plane to 1 at the far one, which shows nothing; reversed, from 1 to 0."""
    planes, way = text.split(",")[:2], text.split(",")[2:]
    near, far = map(float, planes)
    if way not in ([], ["reversed"]) or not 0 < near < far:
        raise ValueError

    def decode(values: NDArray[Any]) -> NDArray[np.float64]:
        share = _shares(values)
        share = 1 - share if way else share
        depth = near / (1 - share * (1 - near / far))
        depth[share >= 1] = np.nan
        return depth

    name = f"{_ZBUFFER}:{near!r},{far!r}{',reversed' * len(way)}"
    return DepthEncoding(name, 1.0, decode, min(far, DEPTH_LIMITS[1]))


def _by_share(text: str) -> DepthEncoding:
    """Shares of the way from the nearest depth, 0 unless stated, to the farthest, which both show nothing."""
    numbers = tuple(float(number) for number in text.split(","))
    near, far = numbers if len(numbers) > 1 else (0.0, *numbers)
    if not 0 <= near < checked_units(far):
        raise ValueError

    def decode(values: NDArray[Any]) -> NDArray[np.float64]:
        share = _shares(values)
        share[(share <= 0) | (share >= 1)] = np.nan
        return np.asarray(near + (far - near) * share)

    return DepthEncoding(f"m/{','.join(map(repr, numbers))}", 1.0, decode, far)


def _shares(values: NDArray[Any]) -> NDArray[np.float64]:
    """Values from 0 to 1, as stored in floats or as shares of the largest of 16 bits; raises FormatError for others."""
    share = values.astype(np.float64) / (UINT16_MAX if values.dtype == np.uint16 else 1)
    largest = np.max(share, initial=0.0, where=np.isfinite(share))
    if largest > 1 + _ROUNDING:
        raise FormatError(f"This encoding applies to 0 to 1, or 16-bit integers, not to {largest:g}. Give another.")
    return share


def _packed(name: str, text: str) -> DepthEncoding:
    """24-bit shares of the farthest depth, which itself shows nothing."""
    far = checked_units(float(text))

    def decode(values: NDArray[Any]) -> NDArray[np.float64]:
        return np.asarray(np.where(values < _LARGEST_PACKED, values * (far / _LARGEST_PACKED), np.nan))

    return DepthEncoding(f"{name}:{far!r}", 1.0, decode, far, _PACKED[name])


def ray_encoding(units: float, camera: Camera) -> str:
    """The name of the encoding of distances along the rays of a camera.

    Parameters
    ----------
    units : float
        File units per metre.
    camera : Camera
        If it has a size, other images are scaled to it.

    Examples
    --------
    >>> ray_encoding(1.0, Camera(3.0, 3.0, 0.0, 0.0))
    'ray:1.0,3.0,3.0,0.0,0.0'
    >>> encoding_of("ray:1,3,3,0,0").metres(np.full((1, 5), 5.0))[0, [0, 4]].tolist()
    [5.0, 3.0]
    """
    numbers = units, camera.fx, camera.fy, camera.cx, camera.cy, *(camera.size or ())
    return f"{_RAY}:{','.join(repr(float(number)) for number in numbers)}"


def _along_rays(text: str) -> DepthEncoding:
    """Distances along rays."""
    units, *numbers = (float(number) for number in text.split(","))
    size = tuple(int(number) if number.is_integer() else 0 for number in numbers[4:])
    if len(numbers) not in {4, 6} or min(size, default=1) < 1:
        raise ValueError
    with told_as(ParameterError, f"'{_RAY}:{text:.80}': {{error}}", InputError):
        fx, fy, cx, cy = numbers[:4]
        camera = Camera(fx, fy, cx, cy, size=(size[0], size[1]) if size else None)

    def decode(values: NDArray[Any]) -> NDArray[np.float64]:
        height, width = values.shape[:2]
        with told_as(FormatError, "{error}", InputError):
            seen = fitted(camera, (height, width))
        x, y = (np.arange(width) - seen.cx) / seen.fx, (np.arange(height) - seen.cy) / seen.fy
        return np.asarray(values.astype(np.float64) / np.sqrt(1 + x**2 + y[:, None] ** 2))

    return DepthEncoding(ray_encoding(checked_units(units), camera), units, decode)


_WITH_NUMBERS: dict[str, tuple[Callable[[str], DepthEncoding], str]] = {
    _BOP: (
        lambda text: DepthEncoding(None, checked_units(1000 / checked_units(float(text)))),
        "bop[:SCALE], by the depth_scale in scene_camera.json (BOP)",
    ),
    _DISPARITY: (
        _by_disparity,
        "disparity:FB[,OFFSET], disparity of a stereo pair, with focal length [px] x baseline [m] FB, and OFFSET added "
        "to it (Middlebury's doffs)",
    ),
    _RAY: (
        _along_rays,
        "ray:UNITS,FX,FY,CX,CY[,WIDTH,HEIGHT], distance along the rays of a camera, UNITS per metre",
    ),
    _ZBUFFER: (
        _by_planes,
        "zbuffer:NEAR,FAR[,reversed], values 0 to 1 of a renderer with near and far plane [m]; FAR may be inf",
    ),
    _SHARE: (_by_share, "m/FAR or m/NEAR,FAR, values 0 to 1 for depth from 0 or NEAR to FAR [m]"),
    "rgb24": (
        partial(_packed, "rgb24"),
        "rgb24:METRES, shares of METRES in 24 bits, lowest in red (CARLA: rgb24:1000)",
    ),
    "bgr24": (partial(_packed, "bgr24"), "bgr24:METRES, shares of METRES in 24 bits, lowest in blue"),
}
"""Name -> what makes the encoding of the numbers behind it, and description."""

ENCODING_DESCRIPTIONS = {name: str(row[-1]) for table in (_FIXED, _WITH_NUMBERS) for name, row in table.items()}
"""Name -> description, for all names that `encoding_of` accepts."""


def needs_scene(spec: EncodingSpec) -> bool:
    """Whether it is "bop", which is defined only for a depth file in its scene."""
    return isinstance(spec, str) and spec.strip().lower() == _BOP


def packed_channels(spec: EncodingSpec | None) -> str:
    """The channels in which an encoding has its values, see `DepthEncoding.channels`; "" for one channel. Raises
    ParameterError if these have no number."""
    return encoding_of(spec).channels if isinstance(spec, str) and _kind(spec) in _PACKED else ""


def is_name(spec: EncodingSpec | None) -> bool:
    """Whether it is the name of an encoding, not a number of units."""
    return isinstance(spec, str) and _kind(spec) in ENCODING_DESCRIPTIONS


def _kind(name: str) -> str:
    """Return a name without its numbers."""
    name = name.strip().lower().partition(":")[0]
    return _SHARE if name.startswith("m/") else name


def single_encoding(encoding: EncodingSpec | None, depth_units: float | None) -> EncodingSpec | None:
    """Return the encoding given by either argument; raise ParameterError if both are given, or it is unknown."""
    if encoding is not None and depth_units is not None:
        both = f"a depth encoding ({encoding}) and depth units ({depth_units})"
        raise ParameterError(f"Both {both} are given: give only one of them.")
    if encoding is not None and not needs_scene(encoding):
        encoding_of(encoding)
    return encoding if depth_units is None else checked_units(depth_units)


def encoding_of_inputs(inputs: FrameInputs) -> DepthEncoding:
    """Return the encoding with which a frame's depth file was read."""
    spec = inputs.depth_units if inputs.encoding is None else inputs.encoding
    return replace(encoding_of(spec), invalid=inputs.invalid)


def default_depth_units(values: NDArray[Any]) -> float:
    """Return the default file units per metre: 1000 (millimetres) for integers, 1 for floats."""
    return 1000.0 if values.dtype.kind in "iu" else 1.0


def checked_number(value: object, needed: str) -> float:
    """Return a real number as float; raise ParameterError, which begins with what is needed, for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ParameterError(f"{needed}, not {value!r:.60}.")
    return as_float(value)


def checked_finite(value: object, what: str, why: str) -> float:
    """Return a finite number as float; raise ParameterError, which names it and ends with a reason, for anything
    else."""
    number = checked_number(value, f"{what} must be a number")
    if not math.isfinite(number):
        raise ParameterError(f"{what} must be a finite number{why}.")
    return number


def checked_units(units: object) -> float:
    """Return file units per metre as float; raise ParameterError unless positive and finite."""
    number = checked_number(units, "Depth units must be a number of file units per metre")
    if not (math.isfinite(number) and number > 0):
        raise ParameterError(f"Depth units must be positive file units per metre (1000 for mm), not {number:g}.")
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
