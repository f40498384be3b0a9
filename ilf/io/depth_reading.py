"""Reading depth files by their encoding, with plausibility warnings."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, with_dataset
from .._runtime.formatting import counted
from ..data.frame import MEDIAN_DEPTH_RANGE, USUAL_MEDIAN_DEPTH, scale_warning
from ..errors import FormatError, told_as
from .depth import UINT16_MAX, checked_depth_values, checked_finite, default_depth_units, read_depth_values
from .encodings import (
    ENCODINGS,
    KINECT_DISPARITY,
    DepthEncoding,
    EncodingSpec,
    beyond_sensor_range,
    encoding_of,
    is_name,
    packed_channels,
)
from .float_images import COLMAP_SUFFIX, KINECT_V2_SUFFIXES, is_kinect_v2
from .heic import HEIC_SUFFIXES
from .other_values import disparity_name, distance_doubt, normalised_doubt, other_way_round

# Signs that a depth file has another unit than assumed, or is not depth: names, sizes, steps and slopes.

_REPLICA_SHAPE = 680, 1200
_REPLICA_NAME = re.compile(r"depth\d{6}\.png")
_KITTI_NAME = re.compile(r"kitti.*|velodyne_raw|groundtruth_depth|proj_depth", re.IGNORECASE)
_KITTI_ASPECT = 3.0
"""Minimum aspect ratio (width / height) of KITTI, which no depth camera has."""

_STREET_MEDIAN, _STREET_FAR, _LIDAR_FAR = 5.0, 30.0, 20.0
"""Minimum median of depth [m] of a street, and minimum 99 % quantiles, the second for depth of KITTI's lidar."""

_LIDAR_SHARE = 0.35
"""Maximum share of known pixels in depth of KITTI's lidar."""

_TASKONOMY_NAME = re.compile(r"_domain_depth(_zbuffer)?\.png")
"""Depth of Taskonomy and 2D-3D-S, in 512 units per metre (github.com/alexsax/2D-3D-Semantics)."""

_NEAR_FOLDERS = 4
"""Number of components at the end of a path, including the file name, that may identify a data set."""

_MIN_PIXELS_OF_VALUE = 20
"""Minimum number of pixels of a value, so that it is not noise."""

_LIKELY_SHARE = 0.99
"""Minimum share of pixels that must be depth for an encoding to be likely."""

_FEWEST_GAPS = 20
_DISPARITY_STEPS = 270.0, 700.0
"""[1/m]; steps of depth are depth squared divided by this: 345 for a Kinect v1, about 600 for a RealSense D400."""

_RISES = 0.5
"""Minimum correlation of rows and values; depth has a negative one in nearly all frames, since the floor is nearer at
the bottom."""

_NEAR, _FAR = 0.5, 6.0
"""Median depth [m]: hardly any frame is below the first, and few above the second."""

_TUM_UNITS, _TUM_NEAREST = 5000.0, 0.35
"""Units of the TUM benchmark, and the depth [m] that 99 % of the depth of its cameras exceed: nearer is most likely in
millimetres, five times as far."""

_GRID = 320
"""Maximum length of the longer side of the subsampled grid [px]."""

_LEVEL, _STEEP = 0.005, 0.2
"""Maximum bend of a straight line, and minimum rise of a slope, relative to the value."""


def data_set_of(
    values: NDArray[Any], metres: NDArray[np.float32], encoding: DepthEncoding, path: Path | None
) -> tuple[str, str] | None:
    """Return the encoding of the data set that integers (H, W), read as `metres` with some known pixels, seem to belong
    to, by their size and range and the names of the file and its folders, and the reason."""
    if values.dtype != np.uint16 or encoding.units != 1000:
        return None
    folders = () if path is None else path.parts[-_NEAR_FOLDERS:]
    is_named = any(map(_KITTI_NAME.fullmatch, folders))
    if (is_named or _is_wide(values)) and not encoding.invalid and values.max() < UINT16_MAX:  # its missing depth is 0
        median, far = np.nanquantile(metres, (0.5, 0.99)) * encoding.units / ENCODINGS["kitti"].units
        is_of_lidar = is_named or np.isfinite(metres).mean() <= _LIDAR_SHARE
        if median >= _STREET_MEDIAN and far >= (_LIDAR_FAR if is_of_lidar else _STREET_FAR):
            return "kitti", f"{'File names match' if is_named else 'Image size and range match'} KITTI"
    is_named = path is not None and _REPLICA_NAME.fullmatch(path.name) is not None
    is_unusual = bool(scale_warning(metres, encoding.units))
    if is_unusual and (
        is_named or values.shape == _REPLICA_SHAPE or any(folder.lower().startswith("replica") for folder in folders)
    ):
        return "replica", "Image size or file names match Replica"
    return None


def _is_wide(values: NDArray[Any]) -> bool:
    return values.dtype == np.uint16 and values.shape[1] >= _KITTI_ASPECT * values.shape[0]


def sensor_scale(values: NDArray[Any], encoding: DepthEncoding) -> tuple[str, str] | None:
    """Return the encoding in which integers have the disparity steps of a depth camera, and the reason; None if they
    have these in the assumed encoding, or no such steps."""
    if values.dtype != np.uint16:
        return None
    levels = np.flatnonzero(_counts(values, encoding.invalid) >= _MIN_PIXELS_OF_VALUE)
    gaps = np.diff(levels)
    is_gap = gaps >= 3  # smaller gaps have too large rounding errors
    if np.count_nonzero(is_gap) < max(_FEWEST_GAPS, 0.2 * gaps.size):
        return None
    low, steps, high = np.quantile(levels[1:][is_gap] ** 2 / gaps[is_gap] / encoding.units, (0.2, 0.5, 0.8))
    if high > 1.6 * low or steps >= _DISPARITY_STEPS[0]:
        return None
    for name, other in ENCODINGS.items():
        if other.name is None and _DISPARITY_STEPS[0] <= steps * encoding.units / other.units <= _DISPARITY_STEPS[1]:
            return name, "Depth has steps that are too coarse for a depth camera at this distance"
    return None


def _counts(values: NDArray[np.uint16], invalid: float | None) -> NDArray[np.intp]:
    """Number of pixels of each value that can be depth, (65536,)."""
    counts = np.bincount(values.ravel(), minlength=UINT16_MAX + 1)
    counts[[0, UINT16_MAX]] = 0  # these are never depth, in any storage
    if invalid not in {None, _NO_DISPARITY, _NO_DISPARITY_SWAPPED}:  # by the latter two a Kinect v1 is known
        counts[np.arange(counts.size) == invalid] = 0
    return counts


def is_inverse(metres: NDArray[np.float32]) -> bool:
    """Whether values (H, W), NaN = missing, that are read as depth [m] seem to be disparity or inverse depth: they
    increase downwards, and their median is unusual for depth, or planes are linear in them."""
    median = float(np.nanmedian(metres))
    step = -(-max(metres.shape) // _GRID)
    grid = metres[::step, ::step].astype(np.float64)
    rows = np.flatnonzero(np.isfinite(grid).any(axis=1))
    if rows.size < 8:
        return False
    depth = np.nanmedian(grid[rows], axis=1)
    if np.ptp(depth) == 0 or np.corrcoef(rows, depth)[0, 1] < _RISES:
        return False
    return median < _NEAR or median > _FAR or _has_straight_planes(grid)


def _has_straight_planes(grid: NDArray[np.float64]) -> bool:
    """Whether slopes are linear in the values rather than in their inverse: planes are linear in inverse depth."""
    straight = slopes = 0
    for lines in (grid, grid.T):
        half = max(lines.shape[0] // 32, 1)
        one, two, mid, three, four = (lines[i * half : lines.shape[0] - (4 - i) * half] for i in range(5))
        with np.errstate(invalid="ignore"):
            bends = [
                np.max([abs((a + c) / (2 * b) - 1) for a, b, c in triples], axis=0)
                for triples in (
                    ((one, mid, four), (one, two, mid), (mid, three, four)),
                    ((1 / one, 1 / mid, 1 / four), (1 / one, 1 / two, 1 / mid), (1 / mid, 1 / three, 1 / four)),
                )
            ]
            counts = (np.minimum(*bends) < _LEVEL) & (abs(four - one) > _STEEP * mid)
        slopes += int(np.count_nonzero(counts))
        straight += int(np.count_nonzero(counts & (bends[0] < bends[1])))
    return slopes >= 0.0005 * grid.size and straight > 0.6 * slopes


# Plausibility checks of the encoding with which a depth file is read.

_NO_DISPARITY, _NO_DISPARITY_SWAPPED = 2047, 65287
_FEWEST_VALUES = 32
_LEAST_SHARE = 0.005
_LARGEST_HIGH_BYTE = 64  # 16 m
_FEWEST_PIXELS = 1000
_FEWEST_HOLES = 10
_MIN_MARKER_DEPTH = 4.0
"""Minimum depth of an invalid marker [m]: markers are farther than most scenes; round numbers below it are depth."""

_MARKER_RATIO = 1.1
"""Minimum ratio of an invalid marker to nearly all other depth."""

_NOISE = 0.0025
"""Maximum share of pixels farther than an invalid marker."""

_NUMBERS_OF_A_FRAME = re.compile(r"\d[\d.e+-]*(%| m\b)")


@dataclass(frozen=True)
class PlausibilityWarning:
    """A plausibility warning about how a file is read.

    Attributes
    ----------
    text : str
        A sentence or two, with what to do.
    encoding : str or None
        The likelier encoding, if any.
    invalid : float or None
        The value that most likely marks missing depth, if any.
    is_scale : bool
        Whether the only reason is an unusual scale or a name, which those who state the encoding are not warned of.
    invalid_depth : float or None
        `invalid` as depth [m].
    """

    text: str
    encoding: str | None = None
    invalid: float | None = None
    is_scale: bool = False
    invalid_depth: float | None = None


def unique_warnings(texts: Iterable[str], known: set[str]) -> list[str]:
    """Return plausibility warnings of several frames, each once: texts that differ only in shares and depths are equal.

    Parameters
    ----------
    texts : iterable of str
    known : set of str
        Earlier texts, as added by this function; new ones are added.

    Examples
    --------
    >>> unique_warnings(["0 fills 3.1%.", "0 fills 4.2%.", "65535 fills 4.2%."], set())
    ['0 fills 3.1%.', '65535 fills 4.2%.']
    """
    first = []
    for text in texts:
        kind = _NUMBERS_OF_A_FRAME.sub("", text)
        if kind not in known:
            known.add(kind)
            first.append(text)
    return first


def plausibility_warnings_of(
    values: NDArray[Any],
    metres: NDArray[np.float32],
    encoding: DepthEncoding,
    is_named: bool,
    path: Path | None = None,
) -> tuple[PlausibilityWarning, ...]:
    """Check how a file's values are read and return plausibility warnings.

    Parameters
    ----------
    values : ndarray
        (H, W), as stored in the file.
    metres : ndarray of float32
        The values as depth [m], (H, W), NaN = missing.
    encoding : DepthEncoding
        The encoding used.
    is_named : bool
        Whether the encoding was given by name: then only the direction of a z-buffer is checked. A number of units
        alone does not exclude rotated bits, swapped bytes or disparity.
    path : Path, optional
        The file, whose name may be that of a data set.
    """
    is_plain = not is_named and encoding.name is None
    is_known = bool(np.isfinite(metres).any())
    may_be_normalised = is_plain and is_known and not data_set_of(values, metres, encoding, path)
    if may_be_normalised and (text := normalised_doubt(values, metres)):
        return (PlausibilityWarning(text),)
    if text := other_way_round(metres, encoding.name):
        return (PlausibilityWarning(text),)
    found = []
    if is_plain and values.dtype == np.uint16:
        found += [doubt for doubt in (_other_storage(values, metres, encoding, path),) if doubt]
    storage = next((ENCODINGS[doubt.encoding] for doubt in found if doubt.encoding), encoding)
    if encoding.invalid is None and storage.name not in KINECT_DISPARITY:  # which decode their own invalid value
        found += [doubt for doubt in (marker_doubt(values, metres),) if doubt]
    if is_plain and is_known and not found:
        found += [doubt for doubt in (_scale(values, metres, encoding, path),) if doubt]
    if is_plain and path is not None and (text := distance_doubt(path)):
        found.append(PlausibilityWarning(text, is_scale=True))
    return tuple(found)


def _scale(
    values: NDArray[Any], metres: NDArray[np.float32], encoding: DepthEncoding, path: Path | None
) -> PlausibilityWarning | None:
    """Check for values that are not depth, or depth in another unit."""
    unusual = scale_warning(metres, encoding.units)
    named = disparity_name(path)
    if named or (not unusual and is_inverse(metres)):
        median = float(np.nanmedian(metres))
        is_usual = median <= USUAL_MEDIAN_DEPTH[1] and not named  # depth of a table may be very near
        sign = "Values increase towards the bottom of the image, where depth usually decreases"
        sign = f"The name {named} says that values are no depth" if named else sign
        return PlausibilityWarning(
            f"{sign}, and their median would be {median:.2f} m: they {'may be' if is_usual else 'are most likely'} "
            "disparity or inverse depth. Give disparity:FB (focal length [px] times baseline [m]; disparity:1 for "
            "inverse depth; disparity:FB,DOFFS with the doffs of Middlebury's calib.txt) if they are, or m or mm if "
            "they are depth."
        )
    if encoding.units == ENCODINGS["mm"].units and _are_8_bits(values):
        return PlausibilityWarning(
            f"No value is above 255, as in an 8-bit image, and depth would end at {np.nanmax(metres):.3f} m: this is "
            "most likely not raw depth. Export raw 16-bit depth, or give mm, or another encoding, by name."
        )
    for found in (
        data_set_of(values, metres, encoding, path),
        sensor_scale(values, encoding),
        _too_near_for_tum(values, metres, encoding.units),
    ):
        if found is not None and (doubt := _doubt(found[1], found[0], values, metres, encoding.invalid)):
            return doubt
    if not unusual and encoding.units == 1000 and _is_wide(values):
        unusual = (
            f"The image is {values.shape[1] / values.shape[0]:.1f} times as wide as high, which no depth camera's is: "
            f"a median of {np.nanmedian(metres):.2f} m, in millimetres, may be wrong; in centimetres it would be "
            f"{10 * np.nanmedian(metres):.2f} m. Give the depth encoding by name (mm, cm)."
        )
    if unusual and values.dtype == np.uint16 and (halves := _median_of_halves(values)):
        unusual += f" If the values are bits of half-precision floats (as of CO3D), float16 gives {halves:.2f} m."
    return PlausibilityWarning(unusual, is_scale=True) if unusual else None


def _median_of_halves(values: NDArray[np.uint16]) -> float | None:
    """The median of the depth [m] whose half-precision bits 16-bit integers may be; None if some would be absurd."""
    metres = ENCODINGS["float16"].metres(values[values > 0])
    low, high = MEDIAN_DEPTH_RANGE
    return float(np.median(metres)) if bool(((metres >= low) & (metres <= high)).mean() > _LIKELY_SHARE) else None


def _too_near_for_tum(values: NDArray[Any], metres: NDArray[np.float32], units: float) -> tuple[str, str] | None:
    """Return millimetres, and the reason, for integers whose depth is too near for the TUM benchmark's units."""
    if values.dtype != np.uint16 or units != _TUM_UNITS:
        return None
    nearest = float(np.nanquantile(metres, 0.01))
    if nearest >= _TUM_NEAREST:
        return None
    return "mm", f"Depth begins at {nearest:.2f} m, nearer than the cameras of the TUM benchmark measure"


def marker_doubt(values: NDArray[Any], metres: NDArray[np.float32]) -> PlausibilityWarning | None:
    """Check values (H, W), read as `metres`, for an invalid marker: one value far from all others in a share of the
    pixels, with only noise beyond."""
    known = metres[np.isfinite(metres)]
    if not known.size:
        return None
    noise = min(int(_NOISE * metres.size) + 1, known.size)
    farthest = known.max(), np.partition(known, -noise)[-noise]
    return next(
        (doubt for far in dict.fromkeys(map(float, farthest)) if (doubt := _marker_warning(far, values, metres))), None
    )


def _marker_warning(far: float, values: NDArray[Any], metres: NDArray[np.float32]) -> PlausibilityWarning | None:
    is_mark = metres == far
    others, share = metres[metres < far], float(is_mark.mean())  # comparisons with NaN are false
    mark = values[is_mark][0]
    is_full = values.dtype.kind in "iu" and mark == np.iinfo(values.dtype).max
    if not others.size or share < (0.001 if is_full else _LEAST_SHARE):
        return None
    most = float(others.max())
    if not (far >= (1.5 if is_full else 5.0) * most or _fills_holes(far, mark, is_mark, others)):
        return None
    all_else = "nearly all other depth" if (metres > far).any() else "all other depth"
    return PlausibilityWarning(
        f"{mark:.9g} fills {share:.1%} of the pixels and would be {far:.3g} m, while {all_else} is at most {most:.3g} "
        f"m: it most likely marks missing depth. Give {mark:.9g} as the invalid value, or 0 if it is depth.",
        invalid=float(mark),
        invalid_depth=far,
    )


def _fills_holes(far: float, mark: Any, is_mark: NDArray[np.bool_], others: NDArray[np.float32]) -> bool:
    """Whether a possible marker is farther than nearly all other depth, which has many values like real depth, and is
    one of the usual numbers or forms many regions, unlike a wall."""
    at = int(0.99 * (others.size - 1))
    if (
        far < _MARKER_RATIO * np.partition(others, at)[at]
        or np.unique(others[:: others.size // 1000 + 1]).size < _FEWEST_VALUES
    ):
        return False
    number = float(mark)
    is_power = number.is_integer() and number >= 2**12 - 1 and int(number + 1).bit_count() == 1
    is_round = f"{number:.6e}".partition("e")[0] in {"1.000000", "2.000000", "5.000000"}
    if far >= _MIN_MARKER_DEPTH and (is_power or is_round):
        return True
    return bool(cv2.connectedComponents(is_mark.astype(np.uint8))[0] > _FEWEST_HOLES)


def _other_storage(
    values: NDArray[np.uint16], metres: NDArray[np.float32], encoding: DepthEncoding, path: Path | None
) -> PlausibilityWarning | None:
    """Check for rotated bits, swapped bytes, or disparity instead of depth, and for a name that states units."""
    invalid = encoding.invalid
    if path is not None and _TASKONOMY_NAME.search(path.name) and encoding.units == ENCODINGS["mm"].units:
        return _doubt("The file name is one of Taskonomy or 2D-3D-S", "taskonomy", values, metres, invalid)
    counts = _counts(values, invalid)
    levels, pixels = np.flatnonzero(counts).astype(np.uint16), counts[counts > 0]
    if pixels.sum() < _FEWEST_PIXELS or levels.size < _FEWEST_VALUES:
        return None
    if _is_swapped(levels, pixels):
        name = "nyu-raw" if _is_disparity(levels.byteswap(), pixels) else "mm-swapped"
        return _doubt("The two bytes of each value seem to be in the wrong order", name, values, metres, invalid)
    if _is_disparity(levels, pixels):
        return _doubt(f"The maximum value is {_NO_DISPARITY}, in many pixels", "kinect-raw", values, metres, invalid)
    if _is_rotated(levels, pixels):
        return _doubt("The lowest three bits of nearly all values are zero", "sun", values, metres, invalid)
    return None


def _doubt(
    sign: str, name: str, values: NDArray[np.uint16], metres: NDArray[np.float32], invalid: float | None
) -> PlausibilityWarning | None:
    """Return a warning; None if the other encoding is implausible, too, or gives about the same depth."""
    other = replace(ENCODINGS[name], invalid=invalid).metres(values)
    if not np.isfinite(other).any():
        return None
    median, present = float(np.nanmedian(other)), float(np.nanmedian(metres))
    if not MEDIAN_DEPTH_RANGE[0] <= median <= MEDIAN_DEPTH_RANGE[1]:
        return None
    if np.mean(np.isclose(other, metres, rtol=0.1)) > 0.5:
        return None
    return PlausibilityWarning(
        f"{sign}: the depth encoding is most likely {name}, with a median of {median:.2f} m instead of "
        f"{present:.2f} m. Give {name}, or the correct encoding, by name.",
        encoding=name,
    )


def _is_swapped(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether the lower bytes are as small as the upper bytes of millimetres, and the upper ones as varied."""
    high, low = levels >> 8, levels & 0xFF
    is_small = np.average(low <= _LARGEST_HIGH_BYTE, weights=pixels) >= 0.999
    return bool(is_small) and np.unique(low).size > 1 and np.unique(high).size >= 2 * _FEWEST_VALUES


def _is_disparity(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether their maximum is the invalid value of a Kinect v1, in many pixels."""
    share = pixels[levels.argmax()] / pixels.sum()
    return bool(levels.max() == _NO_DISPARITY and share >= _LEAST_SHARE)


def _is_rotated(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether nearly all are multiples of 8, and many not of 16."""
    is_whole, is_odd = levels % 8 == 0, levels % 16 == 8
    share = np.average(is_odd, weights=pixels * is_whole) if is_whole.any() else 0.0
    return bool(
        np.average(is_whole, weights=pixels) >= 0.95 and share >= 0.2 and np.count_nonzero(is_whole) >= _FEWEST_VALUES
    )


_SCENE = PlausibilityWarning(
    "Depth maps of COLMAP are in the unit of their reconstruction, which is assumed to be metres: give its units per "
    "metre as depth units, or m as the encoding if it was scaled to metres."
)


_RELATIVE = PlausibilityWarning(
    "This photo states that its depth is relative (as of phones with two lenses): its parts compare, but it may be "
    "metres by name only. Do not measure in it, or give m as the encoding."
)
_SAYS_RELATIVE = re.compile(rb"depthData:Accuracy(>|=[\"'])\s*relative")
"""What Apple's photos say, see AVDepthData.Accuracy.relative."""


@dataclass(frozen=True, eq=False)
class DepthReading:
    """Depth read from a file, with its encoding and plausibility warnings.

    Attributes
    ----------
    values : ndarray
        (H, W), as stored in the file.
    metres : ndarray of float32
        Depth [m], (H, W), NaN = missing.
    encoding : DepthEncoding
    is_assumed : bool
        Whether the encoding was unspecified, so that the default of the values' type was used.
    is_named : bool
        Whether it was given or stated by name.
    left_out : str
        Note on depth left out because it is beyond the range of sensors; "" for none.
    path : Path
        Path of the file.
    is_relative : bool
        Whether it is a photo that says that its depth is not absolute.
    """

    values: NDArray[Any]
    metres: NDArray[np.float32]
    encoding: DepthEncoding
    is_assumed: bool
    is_named: bool
    left_out: str
    path: Path
    is_relative: bool = False

    @cached_property
    def plausibility_warnings(self) -> tuple[PlausibilityWarning, ...]:
        """Plausibility warnings about the encoding."""
        found = plausibility_warnings_of(self.values, self.metres, self.encoding, self.is_named, self.path)
        if self.is_relative and not self.is_named:
            return _RELATIVE, *found
        return (_SCENE, *found) if self.is_assumed and self.path.suffix.lower() == COLMAP_SUFFIX else found

    @property
    def invalid_marker(self) -> float | None:
        """Depth [m] of which a plausibility warning says that it most likely marks missing depth; None without one."""
        return next((doubt.invalid_depth for doubt in self.plausibility_warnings if doubt.invalid is not None), None)

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes for the user, a sentence or two each."""
        return (*([self.left_out] if self.left_out else []), *(doubt.text for doubt in self.plausibility_warnings))

    @property
    def alternative_encodings(self) -> str:
        """The warnings that name a likelier encoding, to append to an error; "" if there are none."""
        return "".join(
            f" {doubt.text}" for doubt in self.plausibility_warnings if doubt.invalid is None and not doubt.is_scale
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Notes to issue as Python warnings, with the path: all except those on an unusual scale if the scale was
        stated."""
        scale = {doubt.text for doubt in self.plausibility_warnings if doubt.is_scale}
        return tuple(f"{self.path}: {note}" for note in self.notes if self.is_assumed or note not in scale)


def read_depth(
    file: FileContent,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
    dataset: str | None = None,
) -> DepthReading:
    """Read a depth file.

    Parameters
    ----------
    file : FileContent
    given, stated : str or float, optional
        The encoding, see `encoding_of`: that given by the user precedes that stated beside the file.
    invalid : float, optional
        The file's value that marks missing depth.
    dataset : str, optional
        The dataset of an HDF5 file, see `read_depth_values`.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `read_depth_values` and `encoding_of` do.
    """
    if stated is None and file.path.suffix.lower() in KINECT_V2_SUFFIXES and is_kinect_v2(file):
        stated = ENCODINGS["mm"].units
    values = read_depth_values(file, packed_channels(stated if given is None else given), dataset)
    read = interpret_depth(values, Path(with_dataset(file.path, dataset)), given, stated, invalid)
    is_photo = file.path.suffix.lower() in HEIC_SUFFIXES
    return replace(read, is_relative=is_photo and _SAYS_RELATIVE.search(file.data.tobytes()) is not None)


def interpret_depth(
    values: NDArray[Any],
    path: Path,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
) -> DepthReading:
    """Interpret the values (H, W) of a depth image from `path`, as `read_depth` does."""
    spec, usual = stated if given is None else given, default_depth_units(checked_depth_values(values, path))
    if invalid is not None:
        invalid = checked_finite(invalid, "The invalid value", ": non-finite values are always missing")
    encoding = replace(encoding_of(usual if spec is None else spec, path), invalid=invalid)
    if given is None and encoding.units == 1 and values.dtype.kind == "f" and _are_8_bits(values):
        raise FormatError(
            f"{path}: its values are whole numbers from 0 to 255, as of an 8-bit image that was stored as float: give "
            "raw depth, or the encoding or units of these values."
        )
    if values.dtype.kind in "if" and _are_negative(values):
        raise FormatError(
            f"{path}: all values are negative, as where a camera looks along -z (Isaac Gym): store them with the other "
            "sign."
        )
    with told_as(FormatError, f"{path}: {{error}}", FormatError):
        metres, left_out = decoded(values, encoding)
    return DepthReading(values, metres, encoding, spec is None, is_name(spec), left_out, path)


def _are_negative(values: NDArray[Any]) -> bool:
    """Whether all that is finite, and there is some, is negative but for zeros."""
    seen = values[np.isfinite(values) & (values != 0)]
    return bool(seen.size and seen.max() < 0)


def _are_8_bits(values: NDArray[Any]) -> bool:
    """Whether values are whole numbers up to 255, and too many different ones for a scene in metres."""
    known = values[np.isfinite(values)]
    if not known.size or (known[:: known.size // 1000 + 1] % 1).any() or (known % 1).any():
        return False
    return bool(known.min() >= 0 and known.max() <= 255 and np.unique(known).size >= _FEWEST_VALUES)


def decoded(values: NDArray[Any], encoding: DepthEncoding) -> tuple[NDArray[np.float32], str]:
    """Convert values to depth [m], NaN = missing, with a note on depth left out beyond the range of sensors, or ""."""
    metres = encoding.metres(values)
    far = beyond_sensor_range(metres, encoding.farthest)
    if far is None:
        return metres, ""
    metres[far] = np.nan
    pixels = counted(int(np.count_nonzero(far)), "pixel")
    return metres, (
        f"Depth beyond {encoding.farthest:g} m, out of range of any sensor, counts as missing: {pixels} "
        f"({far.mean():.1%})."
    )
