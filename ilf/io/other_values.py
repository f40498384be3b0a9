"""Signs that the values of a file are no depth in metres or millimetres: values of a z-buffer, normalised depth, and
distances along rays."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import split_dataset
from ..data.frame import USUAL_MEDIAN_DEPTH
from .depth import UINT16_MAX

_FULL = 1 - 1e-6
"""Share of the largest value that counts as that value, which rounding in single precision may miss."""

_LEAST_OF_BUFFER = 0.9
"""Values of a z-buffer exceed this share of the largest one, unless what they show is very near."""

_BACKGROUND = 0.02
"""Minimum share of pixels that have the largest value, if it stands for nothing seen."""

_LEAST_NEAR = 0.001
"""Minimum share of pixels with values just below the largest of 16 bits."""

_AT_NEAR = 1.1
"""Maximum ratio of depth to that of the near plane where hardly anything is seen, but where the buffer is turned."""

_OTHER_ORDER = {"rgb24": "bgr24", "bgr24": "rgb24"}
_SMOOTHER = 0.1
"""Ratio of the usual difference between neighbours below which the other order of channels is the right one."""

_FEWEST_VALUES = 32
_ROUNDING = 0.01
"""Maximum difference from a whole number after single precision."""


_DISTANCE = re.compile(
    r"(?:^|[^a-z])(distances?|ranges?|euclidean|radial|rays?|raydepth|raylength|depth_?perspective)(?:[^a-z]|$)"
)
_DISPARITY = re.compile(r"(?:^|[^a-z])(disp|disparity|disparities|inv_?depth|inverse_?depth)(?:[^a-z]|$)")
_ALICEVISION = re.compile(r"\d+_depthmap(_filtered)?")
"""Depth maps of AliceVision and Meshroom, which measure along the rays: MultiViewParams::backproject."""

_RECORDINGS = "", ".bag", ".mcap", ".db3", ".mkv", ".r3d"
_NAMES_OF_RAYS = "distance_to_camera", "depthperspective", "depth_perspective"
_NO_DISTANCE = re.compile(r"plane|planar|perpendicular|orthogonal|z_?depth")


def normalised_doubt(values: NDArray[Any], metres: NDArray[np.float32]) -> str:
    """Describe why values (H, W), read as `metres`, are likely a z-buffer or normalised depth; "" if they are not."""
    seen = values[np.isfinite(values) & (values > 0)]
    if not seen.size or not (values.dtype.kind == "f" or values.dtype == np.uint16):
        return ""
    least, largest = float(seen.min()), float(seen.max())
    full = 1.0 if values.dtype.kind == "f" else float(UINT16_MAX)
    if largest > full:
        return ""
    at_largest, median = float(np.mean(values == seen.max())), float(np.nanmedian(metres))
    is_usual = USUAL_MEDIAN_DEPTH[0] <= median <= USUAL_MEDIAN_DEPTH[1]
    if least > _LEAST_OF_BUFFER * full:
        sign = f"all lie between {least:.4g} and {largest:.6g}"
    elif full > 1 and (is_usual or not _reaches(seen)) and not _is_one(metres[values == UINT16_MAX]):
        return ""
    elif largest >= _FULL * full:
        sign = f"they reach exactly {full:g}"
    elif at_largest >= _BACKGROUND and np.unique(seen[:: seen.size // 10_000 + 1]).size >= _FEWEST_VALUES:
        sign = f"{at_largest:.1%} of the pixels have the largest one, {largest:.4g}, like a background"
    elif full == 1 and _are_integers(seen):
        sign = "all are whole multiples of 1/65535, as in an integer image that was scaled to 0 to 1"
    elif not is_usual:
        sign = f"their median is {median:.3g}"
    else:
        return ""
    return (
        f"Values lie in 0 to {full:g}, and {sign}: they may be a z-buffer or normalised depth or inverse depth, which "
        "is in no unit. Give zbuffer:NEAR,FAR by the near and far plane, m/FAR or disparity:1 as the encoding, or "
        f"{'m' if full == 1 else 'mm'} if they are depth."
    )


def other_way_round(metres: NDArray[np.float32], encoding: str | None) -> str:
    """Describe why depth, read as `metres` (H, W) by an encoding with numbers, likely is the other way round: a
    z-buffer from 1 to 0 or from 0 to 1, 24 bits with the lowest in red or in blue; "" if it is not, or of another
    encoding."""
    kind, _, numbers = (encoding or "").partition(":")
    if kind in _OTHER_ORDER and _is_smoother_exchanged(metres, float(numbers)):
        return (
            "Depth jumps from pixel to pixel, and does not with the three channels the other way round. Give "
            f"{_OTHER_ORDER[kind]}:{numbers}."
        )
    if kind != "zbuffer" or not np.isfinite(metres).any():
        return ""
    near, far, *turned = numbers.split(",")
    if np.nanquantile(metres, 0.95) > _AT_NEAR * float(near):
        return ""
    return (
        f"Nearly all depth lies at the near plane, {near} m: the z-buffer is most likely the other way round. Give "
        f"{kind}:{near},{far}{'' if turned else ',reversed'}."
    )


def _is_smoother_exchanged(metres: NDArray[np.float32], far: float) -> bool:
    """Whether depth from 24 bits, the share of `far` [m], differs less between neighbours if its lowest and highest
    bytes are exchanged."""
    values = np.rint(np.nan_to_num(metres).astype(np.float64) / far * (2**24 - 1)).astype(np.int64)
    exchanged = (values & 255) << 16 | values & 0xFF00 | values >> 16
    stored, other = (np.median(np.abs(np.diff(image, axis=1))) if image.size else 0 for image in (values, exchanged))
    return bool(other < _SMOOTHER * stored)


def _are_integers(seen: NDArray[Any]) -> bool:
    """Whether values are those of an image of 8 or 16 bits, divided by the largest possible one."""
    scaled = UINT16_MAX * seen[:: seen.size // 10_000 + 1].astype(np.float64)
    return bool(np.all(np.abs(scaled - np.rint(scaled)) < _ROUNDING) and np.unique(scaled).size >= _FEWEST_VALUES)


def _is_one(metres: NDArray[np.float32]) -> bool:
    """Whether the largest value of 16 bits was converted to 1."""
    return bool(metres.size and abs(metres[0] - 1) < 1 - _FULL)


def _reaches(seen: NDArray[np.uint16]) -> bool:
    """Whether 16-bit values reach the largest one, without a gap below it as there is below an invalid marker."""
    near = (seen > _LEAST_OF_BUFFER * UINT16_MAX) & (seen < UINT16_MAX)
    return bool(seen.max() == UINT16_MAX and np.mean(near) >= _LEAST_NEAR)


def is_named_distance(path: Path) -> bool:
    """Whether a file is named as Isaac Sim or AirSim name distances [m] along rays."""
    return path.stem.lower().startswith(_NAMES_OF_RAYS)


def disparity_name(path: Path | None) -> str:
    """The name of a file that says that it holds disparity or inverse depth; "" if it does not.

    Examples
    --------
    >>> disparity_name(Path("disp0.pfm")), disparity_name(Path("display.png"))
    ('disp0', '')
    """
    found = None if path is None else _DISPARITY.search(path.stem.lower())
    return path.stem if path is not None and found else ""


def distance_doubt(path: Path) -> str:
    """Describe why a file likely holds distances along rays, by its name or its folder's; "" if nothing says so."""
    if path.suffix.lower() in _RECORDINGS and split_dataset(str(path))[1] is None:
        return ""
    for name in (path.stem.lower(), path.parent.name.lower()):
        found = _DISTANCE.search(name) or (path.suffix.lower() == ".exr" and _ALICEVISION.fullmatch(name))
        if found and not _NO_DISTANCE.search(name) and (name != path.parent.name.lower() or _is_only(name)):
            return (
                f"The name {name} says that values are distances along the rays of the camera, which exceed depth "
                "towards the borders of the image. Give ray:UNITS,FX,FY,CX,CY with the camera's intrinsics, or m or mm "
                "if they are depth along the optical axis."
            )
    return ""


def _is_only(folder: str) -> bool:
    """Whether a folder's name has no other words than those about distance to the camera."""
    return all(
        _DISTANCE.search(word) or word in {"depth", "to", "camera", "image", "images", ""}
        for word in re.split(r"[^a-z]", folder)
    )
