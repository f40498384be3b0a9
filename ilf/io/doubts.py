"""What speaks against the encoding that a depth file is read by."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..frame import MEDIAN_DEPTH_RANGE, doubtful_scale
from .depth_files import UINT16_MAX
from .encodings import ENCODINGS, DepthEncoding
from .scale_signs import data_set_of, is_inverse, sensor_scale

_NO_DISPARITY = 2047
_FEWEST_VALUES = 32
_LEAST_SHARE = 0.005
_LARGEST_HIGH_BYTE = 64  # 16 m
_FEWEST_PIXELS = 1000
_FEWEST_HOLES = 10
_NEAREST_MARK = 4.0
"""[m]; marks are farther than most scenes, so that round numbers below it are depth."""

_ABOVE_MOST = 1.1
"""A mark is so many times as far as nearly all else."""

_NOISE = 0.0025
"""Share of the pixels that may be farther than a mark."""

_NUMBERS_OF_A_FRAME = re.compile(r"\d[\d.e+-]*(%| m\b)")


@dataclass(frozen=True)
class Doubt:
    """A reason to read a file in another way.

    Attributes
    ----------
    text : str
        A sentence or two, with the way out.
    encoding : str or None
        The encoding that would be likelier, if it is that.
    invalid : float or None
        The value that most likely stands for missing, if it is that.
    is_scale : bool
        Whether it is but that the scale is unusual.
    """

    text: str
    encoding: str | None = None
    invalid: float | None = None
    is_scale: bool = False


def first_of_each(texts: Iterable[str], known: set[str]) -> list[str]:
    """Doubts of several frames, each once: those that differ in their shares and depths only are the same.

    Parameters
    ----------
    texts : iterable of str
    known : set of str
        Those that were there before, as this function has put them in; what is new is added.

    Examples
    --------
    >>> first_of_each(["0 fills 3.1%.", "0 fills 4.2%.", "65535 fills 4.2%."], set())
    ['0 fills 3.1%.', '65535 fills 4.2%.']
    """
    first = []
    for text in texts:
        kind = _NUMBERS_OF_A_FRAME.sub("", text)
        if kind not in known:
            known.add(kind)
            first.append(text)
    return first


def doubts_of(
    values: NDArray[Any],
    metres: NDArray[np.float32],
    encoding: DepthEncoding,
    is_named: bool,
    path: Path | None = None,
) -> tuple[Doubt, ...]:
    """What speaks against the way that a file's values are read.

    Parameters
    ----------
    values : ndarray
        (H, W), as the file has them.
    metres : ndarray of float32
        Depth [m] that they are read as, (H, W), NaN = missing.
    encoding : DepthEncoding
        That they are read by.
    is_named : bool
        Whether somebody has named the encoding: then it is not doubted. A number of units alone does not say that
        the values are stored plainly.
    path : Path, optional
        The file, whose name may be that of a data set.
    """
    found = []
    if not is_named and encoding.name is None and values.dtype == np.uint16:
        found += [doubt for doubt in (_other_storage(values, metres),) if doubt]
    storage = next((ENCODINGS[doubt.encoding] for doubt in found if doubt.encoding), encoding)
    if encoding.invalid is None and not storage.is_disparity:  # which has a value for missing, and decodes it
        found += [doubt for doubt in (_mark(values, metres),) if doubt]
    if not (found or is_named) and encoding.name is None and np.isfinite(metres).any():
        found += [doubt for doubt in (_scale(values, metres, encoding, path),) if doubt]
    return tuple(found)


def _scale(
    values: NDArray[Any], metres: NDArray[np.float32], encoding: DepthEncoding, path: Path | None
) -> Doubt | None:
    """Values that are no depth, or depth in another unit."""
    unusual = doubtful_scale(metres, encoding.units)
    if not unusual and is_inverse(metres):
        return Doubt(
            f"Values rise towards the bottom of the image, where depth falls, and their median would be "
            f"{np.nanmedian(metres):.2f} m: they are most likely disparity or inverse depth. Give disparity:FB (focal "
            "length [px] times baseline [m]; disparity:1 for inverse depth), or m or mm if they are depth."
        )
    for found in (data_set_of(values, encoding.units, path, bool(unusual)), sensor_scale(values, encoding.units)):
        if found is not None and (doubt := _doubt(found[1], found[0], values, metres)):
            return doubt
    return Doubt(unusual, is_scale=True) if unusual else None


def _mark(values: NDArray[Any], metres: NDArray[np.float32]) -> Doubt | None:
    """One value far from all others that fills a share of the pixels, with nothing but noise beyond it."""
    known = metres[np.isfinite(metres)]
    if not known.size:
        return None
    noise = min(int(_NOISE * metres.size) + 1, known.size)
    farthest = known.max(), np.partition(known, -noise)[-noise]
    return next(
        (doubt for far in dict.fromkeys(map(float, farthest)) if (doubt := _mark_at(far, values, metres))), None
    )


def _mark_at(far: float, values: NDArray[Any], metres: NDArray[np.float32]) -> Doubt | None:
    is_mark = metres == far
    others, share = metres[metres < far], float(is_mark.mean())  # nothing is true of NaN
    mark = values[is_mark][0]
    is_full = values.dtype.kind in "iu" and mark == np.iinfo(values.dtype).max
    if not others.size or share < (0.001 if is_full else _LEAST_SHARE):
        return None
    most = float(others.max())
    if not (far >= (1.5 if is_full else 5.0) * most or _fills_holes(far, mark, is_mark, others)):
        return None
    all_else = "nearly all else" if (metres > far).any() else "all else"
    return Doubt(
        f"{mark:.9g} fills {share:.1%} of the pixels and would be {far:.3g} m, while {all_else} is at most {most:.3g} "
        f"m: it most likely stands for missing. Give {mark:.9g} as the invalid value, or 0 if it is depth.",
        invalid=float(mark),
    )


def _fills_holes(far: float, mark: Any, is_mark: NDArray[np.bool_], others: NDArray[np.float32]) -> bool:
    """Whether what may be a mark is beyond nearly all else, which has the many values of real depth, and is one of the
    usual numbers or lies in many pieces, as no wall does."""
    at = int(0.99 * (others.size - 1))
    if (
        far < _ABOVE_MOST * np.partition(others, at)[at]
        or np.unique(others[:: others.size // 1000 + 1]).size < _FEWEST_VALUES
    ):
        return False
    number = float(mark)
    is_power = number.is_integer() and number >= 2**12 - 1 and int(number + 1).bit_count() == 1
    is_round = f"{number:.6e}".partition("e")[0] in {"1.000000", "2.000000", "5.000000"}
    if far >= _NEAREST_MARK and (is_power or is_round):
        return True
    return bool(cv2.connectedComponents(is_mark.astype(np.uint8))[0] > _FEWEST_HOLES)


def _other_storage(values: NDArray[np.uint16], metres: NDArray[np.float32]) -> Doubt | None:
    """Rotated bits, swapped bytes, or disparity in place of depth."""
    counts = np.bincount(values.ravel(), minlength=UINT16_MAX + 1)
    counts[[0, UINT16_MAX]] = 0  # which are no depth, whatever the storage
    levels, pixels = np.flatnonzero(counts).astype(np.uint16), counts[counts > 0]
    if pixels.sum() < _FEWEST_PIXELS or levels.size < _FEWEST_VALUES:
        return None
    if _is_swapped(levels, pixels):
        name = "nyu-raw" if _is_disparity(levels.byteswap(), pixels) else "mm-swapped"
        return _doubt("The two bytes of each value seem to be in the wrong order", name, values, metres)
    if _is_disparity(levels, pixels):
        return _doubt(f"Values end at {_NO_DISPARITY}, which fills a share", "kinect-raw", values, metres)
    if _is_rotated(levels, pixels):
        return _doubt("The lowest three bits of the values say nothing", "sun", values, metres)
    return None


def _doubt(sign: str, name: str, values: NDArray[np.uint16], metres: NDArray[np.float32]) -> Doubt | None:
    """None if the other encoding makes no sense of them, either, or about the same."""
    other = ENCODINGS[name].metres(values)
    if not np.isfinite(other).any():
        return None
    median, present = float(np.nanmedian(other)), float(np.nanmedian(metres))
    if not MEDIAN_DEPTH_RANGE[0] <= median <= MEDIAN_DEPTH_RANGE[1]:
        return None
    if np.mean(np.isclose(other, metres, rtol=0.1)) > 0.5:
        return None
    return Doubt(
        f"{sign}: the depth encoding is most likely {name}, and the median {median:.2f} m rather than "
        f"{present:.2f} m. Give {name}, or the encoding that it is, by name.",
        encoding=name,
    )


def _is_swapped(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether the lower bytes are as small as the upper ones of millimetres are, and the upper ones as many."""
    high, low = levels >> 8, levels & 0xFF
    is_small = np.average(low <= _LARGEST_HIGH_BYTE, weights=pixels) >= 0.999
    return bool(is_small) and np.unique(low).size > 1 and np.unique(high).size >= 2 * _FEWEST_VALUES


def _is_disparity(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether they end at the value that a Kinect v1 gives where it sees nothing, at many pixels."""
    share = pixels[levels.argmax()] / pixels.sum()
    return bool(levels.max() == _NO_DISPARITY and share >= _LEAST_SHARE)


def _is_rotated(levels: NDArray[np.uint16], pixels: NDArray[np.intp]) -> bool:
    """Whether nearly all are multiples of 8, and many of no more."""
    is_whole, is_odd = levels % 8 == 0, levels % 16 == 8
    share = np.average(is_odd, weights=pixels * is_whole) if is_whole.any() else 0.0
    return bool(
        np.average(is_whole, weights=pixels) >= 0.95 and share >= 0.2 and np.count_nonzero(is_whole) >= _FEWEST_VALUES
    )
