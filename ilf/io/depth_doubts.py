"""Depth as read from a file, and doubts about it: that its encoding or unit is another one, that a value marks missing
depth, that it is no depth, or that it is turned another way than its colour."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import split_dataset
from ..data.frame import MEDIAN_DEPTH_RANGE, USUAL_MEDIAN_DEPTH, scale_warning
from .encodings import ENCODINGS, KINECT_DISPARITY, UINT16_MAX, DepthEncoding
from .float_images import COLMAP_SUFFIX
from .images import turned


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


_SCENE = PlausibilityWarning(
    "Depth maps of COLMAP are in the unit of their reconstruction, which is assumed to be metres: give its units per "
    "metre as depth units, or m as the encoding if it was scaled to metres."
)

_RELATIVE = PlausibilityWarning(
    "This photo states that its depth is relative (as of phones with two lenses): its parts compare, but it may be "
    "metres by name only. Do not measure in it, or give m as the encoding."
)

_NUMBERS_OF_A_FRAME = re.compile(r"\d[\d.e+-]*(%| m\b)")


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
    scales : dict
        What `named_scales` gives of the file; it is not applied.
    """

    values: NDArray[Any]
    metres: NDArray[np.float32]
    encoding: DepthEncoding
    is_assumed: bool
    is_named: bool
    left_out: str
    path: Path
    is_relative: bool = False
    scales: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @cached_property
    def median(self) -> float:
        """The median depth [m] of some known pixels."""
        return float(np.nanmedian(self.metres))

    @property
    def is_wide(self) -> bool:
        """Whether it is integers in an image as wide as KITTI's, which no depth camera's is."""
        return self.values.dtype == np.uint16 and self.values.shape[1] >= _KITTI_ASPECT * self.values.shape[0]

    @cached_property
    def plausibility_warnings(self) -> tuple[PlausibilityWarning, ...]:
        """Plausibility warnings about the encoding."""
        return tuple(_doubts(self))

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


def _doubts(read: DepthReading) -> Iterator[PlausibilityWarning]:
    """Doubts about depth as it was read. If its encoding was given by name, only its direction is looked at; a number
    of units does not exclude rotated bits, swapped bytes or disparity."""
    values, metres, encoding = read.values, read.metres, read.encoding
    is_plain, is_known = not read.is_named and encoding.name is None, bool(np.isfinite(metres).any())
    if read.is_relative and not read.is_named:
        yield _RELATIVE
    if read.is_assumed and read.path.suffix.lower() == COLMAP_SUFFIX:
        yield _SCENE
    no_depth = _normalised(read) if is_plain and is_known and _data_set(read) is None else _other_way_round(read)
    if no_depth:
        yield no_depth
        return
    stated = _stated_scale(read) if is_plain and is_known else None
    storage = _other_storage(read) if is_plain and not stated else None
    used = encoding if storage is None else ENCODINGS[storage.encoding or ""]
    has_marker = encoding.invalid is None and used.name not in KINECT_DISPARITY  # which decode their own invalid value
    marker = marker_doubt(values, metres) if has_marker else None
    scale = stated or (_scale(read) if is_plain and is_known and not (storage or marker) else None)
    rays = _along_rays(read.path) if is_plain else None
    yield from filter(None, (storage, marker, scale, rays))


# Another encoding.

_NO_DISPARITY, _NO_DISPARITY_SWAPPED = 2047, 65287
_LARGEST_HIGH_BYTE = 64  # 16 m
_FEWEST_PIXELS, _FEWEST_VALUES, _LEAST_SHARE = 1000, 32, 0.005

_ALIKE = 400
"""Maximum difference of neighbours in the bits below those of confidence."""

_REPLICA_SHAPE = 680, 1200
_REPLICA_NAME = re.compile(r"depth\d{6}\.png")
_KITTI_NAME = re.compile(r"kitti.*|velodyne_raw|groundtruth_depth|proj_depth", re.IGNORECASE)
_KITTI_ASPECT = 3.0
"""Minimum aspect ratio (width / height) of KITTI, which no depth camera has."""

_STREET_MEDIAN, _STREET_FAR, _LIDAR_FAR = 5.0, 30.0, 20.0
"""Minimum median of depth [m] of a street, and minimum 99 % quantiles, the second for depth of KITTI's lidar."""

_LIDAR_SHARE = 0.35
"""Maximum share of known pixels in depth of KITTI's lidar."""

_SPARSE_SHARE = 0.1
"""Maximum share of known pixels in files for depth completion."""

_TASKONOMY_NAME = re.compile(r"_domain_depth(_zbuffer)?\.png")
"""Depth of Taskonomy and 2D-3D-S, in 512 units per metre (github.com/alexsax/2D-3D-Semantics)."""

_LIKELY_SHARE = 0.99
"""Minimum share of pixels that must be depth for an encoding to be likely."""

_NEAR_FOLDERS = 4
"""Number of components at the end of a path, including the file name, that may identify a data set."""

_MIN_PIXELS_OF_VALUE, _FEWEST_GAPS = 20, 20
"""Minimum number of pixels of a value, so that it is not noise, and of gaps between values."""

_DISPARITY_STEPS = 270.0, 700.0
"""[1/m]; steps of depth are depth squared divided by this: 345 for a Kinect v1, about 600 for a RealSense D400."""

_FINEST_STEPS, _COMMON_STEPS = 1670.0, ((335.0, 360.0), (560.0, 650.0))
"""Likewise: more than nearly all stereo cameras have, and those of the two."""

_TUM_UNITS, _TUM_NEAREST = 5000.0, 0.35
"""Units of the TUM benchmark, and the depth [m] that 99 % of the depth of its cameras exceed: nearer is most likely in
millimetres, five times as far."""


def _likelier(read: DepthReading, name: str, sign: str) -> PlausibilityWarning | None:
    """The warning that another encoding is likelier, by a sign; None if that is implausible, too, or gives about the
    same depth."""
    other = replace(ENCODINGS[name], invalid=read.encoding.invalid).metres(read.values)
    median = float(np.nanmedian(other)) if np.isfinite(other).any() else 0.0
    if not MEDIAN_DEPTH_RANGE[0] <= median <= MEDIAN_DEPTH_RANGE[1]:
        return None
    if np.mean(np.isclose(other, read.metres, rtol=0.1)) > 0.5:
        return None
    instead = f"with a median of {median:.2f} m instead of {np.nanmedian(read.metres):.2f} m"
    told = f"{sign}: the depth encoding is most likely {name}, {instead}. Give {name}, or the correct one, by name."
    return PlausibilityWarning(told, encoding=name)


def _other_storage(read: DepthReading) -> PlausibilityWarning | None:
    """Whether the bits are rotated or the bytes swapped, or values are disparity instead of depth, or the name states
    units."""
    if read.values.dtype != np.uint16:
        return None
    if _TASKONOMY_NAME.search(read.path.name) and read.encoding.units == 1000:
        return _likelier(read, "taskonomy", "The file name is one of Taskonomy or 2D-3D-S")
    counts = _counts(read)
    levels, pixels = np.flatnonzero(counts).astype(np.uint16), counts[counts > 0]
    if pixels.sum() < _FEWEST_PIXELS or levels.size < _FEWEST_VALUES:
        return None
    if _is_swapped(levels, pixels):
        name = "nyu-raw" if _is_disparity(levels.byteswap(), pixels) else "mm-swapped"
        return _likelier(read, name, "The two bytes of each value seem to be in the wrong order")
    if _is_disparity(levels, pixels):
        return _likelier(read, "kinect-raw", f"The maximum value is {_NO_DISPARITY}, in many pixels")
    if _is_rotated(levels, pixels):
        return _likelier(read, "sun", "The lowest three bits of nearly all values are zero")
    if _have_confidence(read.values):
        return _likelier(read, "depth16", "The highest three bits change, or are large, where the others stay")
    return None


def _counts(read: DepthReading) -> NDArray[np.intp]:
    """Number of pixels of each 16-bit value that can be depth, (65536,)."""
    counts = np.bincount(read.values.ravel(), minlength=UINT16_MAX + 1)
    counts[[0, UINT16_MAX]] = 0  # these are never depth, in any storage
    if read.encoding.invalid not in {None, _NO_DISPARITY, _NO_DISPARITY_SWAPPED}:  # by which a Kinect v1 is known
        counts[np.arange(counts.size) == read.encoding.invalid] = 0
    return counts


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
    if np.average(is_whole, weights=pixels) < 0.95 or np.count_nonzero(is_whole) < _FEWEST_VALUES:
        return False
    return bool(np.average(is_odd, weights=pixels * is_whole) >= 0.2)


def _have_confidence(values: NDArray[np.uint16]) -> bool:
    """Whether the highest three bits differ between neighbours that are alike in the others, which millimetres are
    not, or are at least 4 everywhere."""
    known = values > 0
    high, low = values >> 13, (values & 0x1FFF).astype(np.int32)
    beside = known[:, 1:] & known[:, :-1] & (high[:, 1:] != high[:, :-1])
    alike = np.abs(np.diff(low, axis=1))[beside] < _ALIKE
    if alike.size >= _LEAST_SHARE * values.size:
        return bool(alike.mean() > 0.5)
    return alike.size == 0 and bool(high[known].min() >= 4)


def _stated_scale(read: DepthReading) -> PlausibilityWarning | None:
    """Whether the file states a scale by which its depth would be another one, as likely."""
    low, high = MEDIAN_DEPTH_RANGE
    for stated, all_units in read.scales.items():
        medians = {units: read.median * read.encoding.units / units for units in all_units}
        likely = {f"{units:.6g}": far for units, far in medians.items() if low <= far <= high}
        if likely and f"{read.encoding.units:.6g}" not in likely:
            told = f"The file states {stated}, which is not applied: the median is {read.median:.2f} m"
            others = " or ".join(f"{units} ({far:.2f} m)" for units, far in likely.items())
            return PlausibilityWarning(f"{told}. Give {others} as depth encoding, or the right one.", is_scale=True)
    return None


def _scale(read: DepthReading) -> PlausibilityWarning | None:
    """Whether values are not depth, or depth in another unit."""
    values, metres, units = read.values, read.metres, read.encoding.units
    unusual, named = scale_warning(metres, units), disparity_name(read.path)
    near = 0.0 if named else _share_at_camera(read)
    if named or near or (not unusual and _is_inverse(read)):
        sign = "Values increase towards the bottom of the image, where depth usually decreases"
        sign = f"{near:.1%} of the pixels would lie within {_AT_CAMERA:g} m of the camera" if near else sign
        sign = f"The name {named} says that values are no depth" if named else sign
        may_be = "may be" if read.median <= USUAL_MEDIAN_DEPTH[1] and not named else "are most likely"  # or a table
        return PlausibilityWarning(
            f"{sign}, and their median would be {read.median:.2f} m: they {may_be} disparity or inverse depth. If so, "
            "give disparity:FB (focal length [px] times baseline [m], times 256 for KITTI's; 1 for inverse depth; "
            "disparity:FB,DOFFS with the doffs of Middlebury's calib.txt), else m or mm. A network's estimate (MiDaS, "
            "Depth Anything) has no unit: use it as a guide."
        )
    if units == ENCODINGS["mm"].units and are_8_bits(values):
        far = f"No value is above 255, as in an 8-bit image, and depth would end at {np.nanmax(metres):.3f} m"
        told = f"{far}: this is most likely not raw depth. Export raw 16-bit depth, or give mm, or another encoding."
        return PlausibilityWarning(told)
    likelier = (found for find in (_data_set, _sensor_steps, _too_near_for_tum) if (found := find(read)))
    if doubt := next(filter(None, (_likelier(read, *found) for found in likelier)), None):
        return doubt
    if not unusual and units == 1000 and _is_sparse(read):
        share = f"Only {np.isfinite(metres).mean():.1%} of the pixels have depth, as in files of VOID or KITTI"
        unusual = f"{share}: its median may be {read.median * units / 256:.2f} m, not {read.median:.2f} m. "
        unusual += "Give the depth encoding by name (mm, kitti)."
    if not unusual and units == 1000 and read.is_wide:
        wide = f"The image is {values.shape[1] / values.shape[0]:.1f} times as wide as high, as no depth camera's"
        medians = f"its median may be {10 * read.median:.2f} m, in centimetres, not {read.median:.2f} m"
        unusual = f"{wide}: {medians}. Give the depth encoding by name (mm, cm)."
    if unusual and values.dtype == np.uint16 and (halves := _median_of_halves(values)):
        unusual += f" If the values are bits of half-precision floats (as of CO3D), float16 gives {halves:.2f} m."
    return PlausibilityWarning(unusual, is_scale=True) if unusual else None


def _is_sparse(read: DepthReading) -> bool:
    """Whether few pixels of integers are known, and most of them alone, as of features or of a lidar."""
    known = np.isfinite(read.metres)
    is_scattered = np.count_nonzero(known[:, 1:] & known[:, :-1]) < 0.5 * np.count_nonzero(known)
    return bool(read.values.dtype == np.uint16 and known.mean() < _SPARSE_SHARE and is_scattered)


def _median_of_halves(values: NDArray[np.uint16]) -> float | None:
    """The median of the depth [m] whose half-precision bits 16-bit integers may be; None if some would be absurd."""
    metres = ENCODINGS["float16"].metres(values[values > 0])
    low, high = MEDIAN_DEPTH_RANGE
    return float(np.median(metres)) if bool(((metres >= low) & (metres <= high)).mean() > _LIKELY_SHARE) else None


def _data_set(read: DepthReading) -> tuple[str, str] | None:
    """The encoding of the data set that integers with some known depth seem to belong to, by their size and range and
    the names of the file and its folders, and the reason."""
    values, metres, encoding, path = read.values, read.metres, read.encoding, read.path
    if values.dtype != np.uint16 or encoding.units != 1000:
        return None
    folders = path.parts[-_NEAR_FOLDERS:]
    is_named = any(map(_KITTI_NAME.fullmatch, folders))
    if (is_named or read.is_wide) and not encoding.invalid and values.max() < UINT16_MAX:  # its missing depth is 0
        median, far = np.nanquantile(metres, (0.5, 0.99)) * encoding.units / ENCODINGS["kitti"].units
        is_of_lidar = is_named or np.isfinite(metres).mean() <= _LIDAR_SHARE
        if median >= _STREET_MEDIAN and far >= (_LIDAR_FAR if is_of_lidar else _STREET_FAR):
            return "kitti", f"{'File names match' if is_named else 'Image size and range match'} KITTI"
    is_named = _REPLICA_NAME.fullmatch(path.name) is not None
    is_named = is_named or any(folder.lower().startswith("replica") for folder in folders)
    if (is_named or values.shape == _REPLICA_SHAPE) and scale_warning(metres, encoding.units):
        return "replica", "Image size or file names match Replica"
    return None


def _sensor_steps(read: DepthReading) -> tuple[str, str] | None:
    """The encoding in which integers have the disparity steps of a depth camera, and the reason; None if they have
    these in the assumed encoding, or no such steps."""
    if read.values.dtype != np.uint16:
        return None
    units, levels = read.encoding.units, np.flatnonzero(_counts(read) >= _MIN_PIXELS_OF_VALUE)
    gaps = np.diff(levels)
    is_gap = gaps >= 3  # smaller gaps have too large rounding errors
    if np.count_nonzero(is_gap) < max(_FEWEST_GAPS, 0.2 * gaps.size):
        return None
    low, steps, high = np.quantile(levels[1:][is_gap] ** 2 / gaps[is_gap] / units, (0.2, 0.5, 0.8))
    is_fine = steps > _FINEST_STEPS
    kind, usual = ("fine", _COMMON_STEPS) if is_fine else ("coarse", (_DISPARITY_STEPS,))
    if high > (1.25 if is_fine else 1.6) * low or _DISPARITY_STEPS[0] <= steps <= _FINEST_STEPS:
        return None
    plain = [(name, other.units) for name, other in ENCODINGS.items() if other.name is None]
    for (least, most), (name, other) in product(usual, plain):
        if least <= steps * units / other <= most:
            return name, f"Depth has steps that are too {kind} for a depth camera at this distance"
    return None


def _too_near_for_tum(read: DepthReading) -> tuple[str, str] | None:
    """Millimetres, and the reason, for integers whose depth is too near for the TUM benchmark's units."""
    if read.values.dtype != np.uint16 or read.encoding.units != _TUM_UNITS:
        return None
    nearest = float(np.nanquantile(read.metres, 0.01))
    if nearest >= _TUM_NEAREST:
        return None
    return "mm", f"Depth begins at {nearest:.2f} m, nearer than the cameras of the TUM benchmark measure"


# A marker of missing depth.

_FEWEST_HOLES = 10
_MIN_MARKER_DEPTH = 4.0
"""Minimum depth of an invalid marker [m]: markers are farther than most scenes; round numbers below it are depth."""

_MARKER_RATIO = 1.1
"""Minimum ratio of an invalid marker to nearly all other depth."""

_NEAR_MARKER_RATIO = 5.0
"""Minimum ratio of nearly all other depth to an invalid marker that is nearer."""

_NOISE = 0.0025
"""Maximum share of pixels farther than an invalid marker."""


def marker_doubt(values: NDArray[Any], metres: NDArray[np.float32]) -> PlausibilityWarning | None:
    """Check values (H, W), read as `metres`, for an invalid marker: one value far from all others in a share of the
    pixels, with only noise beyond."""
    known = metres[np.isfinite(metres)]
    if not known.size:
        return None
    noise = min(int(_NOISE * metres.size) + 1, known.size)
    farthest = dict.fromkeys(map(float, (known.max(), np.partition(known, -noise)[-noise])))
    warnings = (_marker_warning(far, values, metres) for far in farthest)
    return next(filter(None, warnings), None) or _near_marker(values, metres)


def _near_marker(values: NDArray[Any], metres: NDArray[np.float32]) -> PlausibilityWarning | None:
    """Likewise, for the smallest value, as of depth that was raised to a positive minimum."""
    is_mark = metres == np.nanmin(metres)
    others, share = metres[np.isfinite(metres) & ~is_mark], float(is_mark.mean())
    if share < _LEAST_SHARE or np.unique(others[:: others.size // 1000 + 1]).size < _FEWEST_VALUES:
        return None
    near, least = float(metres[is_mark][0]), float(np.quantile(others, _NOISE))
    if least < _NEAR_MARKER_RATIO * near:
        return None
    return _marker(values[is_mark][0], share, near, f"nearly all other depth is at least {least:.3g} m")


def _marker(mark: Any, share: float, depth: float, others: str) -> PlausibilityWarning:
    fills = f"{mark:.9g} fills {share:.1%} of the pixels and would be {depth:.3g} m, while {others}"
    told = f"{fills}: it most likely marks missing depth. Give {mark:.9g} as the invalid value, or 0 if it is depth."
    return PlausibilityWarning(told, invalid=float(mark), invalid_depth=depth)


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
    return _marker(mark, share, far, f"{all_else} is at most {most:.3g} m")


def _fills_holes(far: float, mark: Any, is_mark: NDArray[np.bool_], others: NDArray[np.float32]) -> bool:
    """Whether a possible marker is farther than nearly all other depth, which has many values like real depth, and is
    one of the usual numbers or forms many regions, unlike a wall."""
    at = int(0.99 * (others.size - 1))
    is_far, is_depth = far >= _MARKER_RATIO * np.partition(others, at)[at], others[:: others.size // 1000 + 1]
    if not is_far or np.unique(is_depth).size < _FEWEST_VALUES:
        return False
    number = float(mark)
    is_power = number.is_integer() and number >= 2**12 - 1 and int(number + 1).bit_count() == 1
    is_round = f"{number:.6e}".partition("e")[0] in {"1.000000", "2.000000", "5.000000"}
    if far >= _MIN_MARKER_DEPTH and (is_power or is_round):
        return True
    return bool(cv2.connectedComponents(is_mark.astype(np.uint8))[0] > _FEWEST_HOLES)


# Disparity and inverse depth.

_RISES = 0.5
"""Minimum correlation of rows and values; depth has a negative one in nearly all frames, since the floor is nearer at
the bottom."""

_NEAR, _FAR = 0.5, 6.0
"""Median depth [m]: hardly any frame is below the first, and few above the second."""

_GRID = 320
"""Maximum length of the longer side of the subsampled grid [px]."""

_LEVEL, _STEEP = 0.005, 0.2
"""Maximum bend of a straight line, and minimum rise of a slope, relative to the value."""

_DISPARITY = re.compile(r"(?:^|[^a-z])(disp|disparity|disparities|inv_?depth|inverse_?depth)(?:[^a-z]|$)")


def disparity_name(path: Path) -> str:
    """The name of a file, or of its folder, that says that values are disparity or inverse depth; "" if none.

    Examples
    --------
    >>> disparity_name(Path("disp0.pfm")), disparity_name(Path("display.png"))
    ('disp0', '')
    >>> disparity_name(Path("disp_occ_0/000000_10.png")), disparity_name(Path("disparity/left/0006.pfm"))
    ('disp_occ_0', 'disparity')
    """
    folders = (folder.name for folder in path.parents[:2] if _is_only(folder.name.lower(), _DISPARITY))
    return next((name for name in (path.stem, *folders) if _DISPARITY.search(name.lower())), "")


_AT_CAMERA, _NEARER = 0.1, 0.02
"""Depth [m], and its ratio to the median, that no camera measures and hardly any scene has."""


def _share_at_camera(read: DepthReading) -> float:
    """The share of the pixels of floats without gaps, at whose borders they may be interpolated, that would be
    impossibly near, in many values, as inverse depth of what is far, of networks; 0 for few."""
    near = read.metres[read.metres < min(_AT_CAMERA, _NEARER * read.median)]
    is_dense = read.values.dtype.kind == "f" and np.isfinite(read.metres).mean() >= _LIKELY_SHARE
    share = near.size / read.metres.size
    return share if is_dense and share >= _LEAST_SHARE and np.unique(near).size >= _FEWEST_VALUES else 0.0


def _is_inverse(read: DepthReading) -> bool:
    """Whether depth seems to be disparity or inverse depth: it increases downwards, and its median is unusual for
    depth, or planes are linear in it."""
    step = -(-max(read.metres.shape) // _GRID)
    grid = read.metres[::step, ::step].astype(np.float64)
    rows = np.flatnonzero(np.isfinite(grid).any(axis=1))
    if rows.size < 8:
        return False
    depth = np.nanmedian(grid[rows], axis=1)
    if np.ptp(depth) == 0 or np.corrcoef(rows, depth)[0, 1] < _RISES:
        return False
    return not _NEAR <= read.median <= _FAR or _has_straight_planes(grid)


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


# A z-buffer, or normalised depth.

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

_ROUNDING = 0.01
"""Maximum difference from a whole number after single precision."""


def _normalised(read: DepthReading) -> PlausibilityWarning | None:
    """Whether values with some known depth are likely a z-buffer or normalised depth."""
    values, metres = read.values, read.metres
    seen = values[np.isfinite(values) & (values > 0)]
    if not seen.size or not (values.dtype.kind == "f" or values.dtype == np.uint16):
        return None
    least, largest = float(seen.min()), float(seen.max())
    full, unit = (1.0, "m") if values.dtype.kind == "f" else (float(UINT16_MAX), "mm")
    if largest > full:
        return None
    at_largest = float(np.mean(values == seen.max()))
    is_usual = USUAL_MEDIAN_DEPTH[0] <= read.median <= USUAL_MEDIAN_DEPTH[1]
    near = np.mean((seen > _LEAST_OF_BUFFER * full) & (seen < full))
    of_full = metres[values == full]
    is_one = of_full.size > 0 and abs(of_full[0] - 1) < 1 - _FULL
    if least > _LEAST_OF_BUFFER * full:
        sign = f"all lie between {least:.4g} and {largest:.6g}"
    elif full > 1 and not is_one and (is_usual or largest < full or near < _LEAST_NEAR):
        return None  # usual depth, or a gap below the largest value as below an invalid marker
    elif largest >= _FULL * full:
        sign = f"they reach exactly {full:g}"
    elif at_largest >= _BACKGROUND and np.unique(seen[:: seen.size // 10_000 + 1]).size >= _FEWEST_VALUES:
        sign = f"{at_largest:.1%} of the pixels have the largest one, {largest:.4g}, like a background"
    elif full == 1 and _are_integers(seen):
        sign = "all are whole multiples of 1/65535, as in an integer image that was scaled to 0 to 1"
    elif not is_usual:
        sign = f"their median is {read.median:.3g}"
    else:
        return None
    return PlausibilityWarning(
        f"Values lie in 0 to {full:g}, and {sign}: they may be a z-buffer or normalised depth or inverse depth, in no "
        f"unit. Give zbuffer:NEAR,FAR, m/FAR, m/NEAR,FAR or disparity:1 as the encoding, or {unit} if they are depth."
    )


def _are_integers(seen: NDArray[Any]) -> bool:
    """Whether values are those of an image of 8 or 16 bits, divided by the largest possible one."""
    scaled = UINT16_MAX * seen[:: seen.size // 10_000 + 1].astype(np.float64)
    return bool(np.all(np.abs(scaled - np.rint(scaled)) < _ROUNDING) and np.unique(scaled).size >= _FEWEST_VALUES)


def _other_way_round(read: DepthReading) -> PlausibilityWarning | None:
    """Whether depth by an encoding with numbers likely is the other way round: a z-buffer from 1 to 0 or from 0 to 1,
    24 bits with the lowest in red or in blue."""
    kind, _, numbers = (read.encoding.name or "").partition(":")
    if kind in _OTHER_ORDER and _is_smoother_exchanged(read.metres, float(numbers)):
        jumps = "Depth jumps from pixel to pixel, and does not with the three channels the other way round"
        return PlausibilityWarning(f"{jumps}. Give {_OTHER_ORDER[kind]}:{numbers}.")
    if kind != "zbuffer" or not np.isfinite(read.metres).any():
        return None
    near, far, *turned = numbers.split(",")
    if np.nanquantile(read.metres, 0.95) > _AT_NEAR * float(near):
        return None
    told = f"Nearly all depth lies at the near plane, {near} m: the z-buffer is most likely the other way round"
    return PlausibilityWarning(f"{told}. Give {kind}:{near},{far}{'' if turned else ',reversed'}.")


def _is_smoother_exchanged(metres: NDArray[np.float32], far: float) -> bool:
    """Whether depth from 24 bits, the share of `far` [m], differs less between neighbours if its lowest and highest
    bytes are exchanged."""
    values = np.rint(np.nan_to_num(metres).astype(np.float64) / far * (2**24 - 1)).astype(np.int64)
    exchanged = (values & 255) << 16 | values & 0xFF00 | values >> 16
    stored, other = (np.median(np.abs(np.diff(image, axis=1))) if image.size else 0 for image in (values, exchanged))
    return bool(other < _SMOOTHER * stored)


def are_8_bits(values: NDArray[Any]) -> bool:
    """Whether values are whole numbers up to 255, and too many different ones for a scene in metres."""
    known = values[np.isfinite(values)]
    if not known.size or (known[:: known.size // 1000 + 1] % 1).any() or (known % 1).any():
        return False
    return bool(known.min() >= 0 and known.max() <= 255 and np.unique(known).size >= _FEWEST_VALUES)


# Distances along rays.

_DISTANCE = re.compile(
    r"(?:^|[^a-z])(distances?|ranges?|euclidean|radial|rays?|raydepth|raylength|depth_?perspective)(?:[^a-z]|$)"
)
_NAMES_BY_MAKERS = {
    ".exr": re.compile(r"\d+_depthmap(_filtered)?"),
    ".hdf5": re.compile(r"frame\.\d+\.depth_meters"),
}
"""Suffix -> names of depth along the rays: AliceVision and Meshroom (MultiViewParams::backproject), and Hypersim."""

_RECORDINGS = "", ".bag", ".mcap", ".db3", ".mkv", ".r3d"
_NAMES_OF_RAYS = "distance_to_camera", "depthperspective", "depth_perspective"
_NO_DISTANCE = re.compile(r"plane|planar|perpendicular|orthogonal|z_?depth")


def is_named_distance(path: Path) -> bool:
    """Whether a file is named as Isaac Sim or AirSim name distances [m] along rays."""
    return path.stem.lower().startswith(_NAMES_OF_RAYS)


def _along_rays(path: Path) -> PlausibilityWarning | None:
    """Whether a file likely holds distances along rays, by its name or its folder's."""
    if path.suffix.lower() in _RECORDINGS and split_dataset(str(path))[1] is None:
        return None
    file, folder = path.stem.lower(), path.parent.name.lower()
    for name in (file, folder):
        of_maker = _NAMES_BY_MAKERS.get(path.suffix.lower())
        found = _DISTANCE.search(name) or (of_maker and of_maker.fullmatch(name))
        if found and not _NO_DISTANCE.search(name) and (name != folder or _is_only(name, _DISTANCE)):
            told = f"The name {name} says that values are distances along the rays of the camera, not depth"
            remedy = "Give ray:UNITS,FX,FY,CX,CY with the camera's intrinsics, or m or mm if they are depth."
            return PlausibilityWarning(f"{told}. {remedy}", is_scale=True)
    return None


def _is_only(folder: str, names: re.Pattern[str]) -> bool:
    """Whether a folder's name has no other words than such names and those of images."""
    others = re.split(r"[^a-z]", names.sub("_", folder))
    return {*others} <= {"depth", "to", "camera", "image", "images", "map", "maps", "occ", "noc", "left", "right", ""}


CLEAR = 0.15
"""Minimum correlation of the edges of colour and depth to tell by them which way they are turned."""

_COMPARED = 160
"""Length of the longer side [px] at which edges are compared."""

_JUMP = 0.1
"""Minimum jump of depth between neighbours there, relative to depth."""

_WAYS = {2: "mirrored", 3: "turned by 180 degrees", 4: "upside down"}
_WAYS_OF_SQUARES = {5: "with rows and columns exchanged", 6: "turned by 90 degrees", 8: "turned by 90 degrees"}
_LEAST_SIDE, _CLEARLY_BETTER = 100, 0.12
"""Minimum length of the sides [px], since smaller images have few edges, and minimum lead over images as stored."""


def turning_doubt(colour: NDArray[np.uint8], metres: NDArray[np.float32]) -> str:
    """A doubt whether one of two images of the same size is mirrored or upside down, by their edges; "" for none."""
    if min(metres.shape) < _LEAST_SIDE:
        return ""
    ways = _WAYS if metres.shape[0] != metres.shape[1] else _WAYS | _WAYS_OF_SQUARES
    best, tag = max((coincidence(colour, turned(metres, tag)), tag) for tag in ways)
    if best < max(CLEAR, coincidence(colour, metres) + _CLEARLY_BETTER):
        return ""
    told = f"Edges of colour and depth coincide better if one of them is {ways[tag]}"
    return f"{told}. If it is, save its file the right way."


def coincidence(colour: NDArray[np.uint8], metres: NDArray[np.float32]) -> float:
    """Correlation of the edges of colour and the jumps of depth, -1 to 1; 0 if there are none."""
    step = -(-max(metres.shape) // _COMPARED)
    depth = np.log(metres[::step, ::step])
    steps = [np.abs(np.diff(depth, axis=axis, append=np.nan)) > _JUMP for axis in (0, 1)]
    jumps = np.any(steps, axis=0).astype(np.float32)
    grey: Any = cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY).astype(np.float32)
    grey = cv2.resize(grey, jumps.shape[::-1], interpolation=cv2.INTER_AREA)
    edges = cv2.magnitude(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
    blurred, other = (np.asarray(cv2.GaussianBlur(values, (0, 0), 1)).ravel() for values in (edges, jumps))
    one = np.log1p(blurred)
    if np.ptp(one) == 0 or np.ptp(other) == 0:
        return 0.0
    return float(np.corrcoef(one, other)[0, 1])
