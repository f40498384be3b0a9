"""What speaks against the encoding that a depth file is read by."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..frame import MEDIAN_DEPTH_RANGE, doubtful_scale
from .depth_files import UINT16_MAX
from .encodings import ENCODINGS, DepthEncoding

_NO_DISPARITY = 2047
_FEWEST_VALUES = 32
_LEAST_SHARE = 0.005
_LARGEST_HIGH_BYTE = 64  # 16 m
_FEWEST_PIXELS = 1000


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
    """

    text: str
    encoding: str | None = None
    invalid: float | None = None


def doubts_of(
    values: NDArray[Any], metres: NDArray[np.float32], encoding: DepthEncoding, is_named: bool
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
    """
    found = []
    if not is_named and encoding.name is None and values.dtype == np.uint16:
        found += [doubt for doubt in (_other_storage(values, metres),) if doubt]
    storage = next((ENCODINGS[doubt.encoding] for doubt in found if doubt.encoding), encoding)
    if encoding.invalid is None and not storage.is_disparity:  # which has a value for missing, and decodes it
        found += [doubt for doubt in (_mark(values, metres),) if doubt]
    if not (found or is_named) and encoding.name is None and np.isfinite(metres).any():
        scale = doubtful_scale(metres, encoding.units)
        found += [Doubt(scale)] if scale else []
    return tuple(found)


def _mark(values: NDArray[Any], metres: NDArray[np.float32]) -> Doubt | None:
    """One extreme value that fills a share of the pixels, with nothing near it."""
    known = np.isfinite(metres)
    if not known.any():
        return None
    farthest = float(metres[known].max())  # products of which float32 may not hold
    is_mark = known & (metres == farthest)
    others, share = metres[known & ~is_mark], float(is_mark.mean())
    mark = values[is_mark][0]
    is_full = values.dtype.kind in "iu" and mark == np.iinfo(values.dtype).max
    least_share, gap = (0.001, 1.5) if is_full else (_LEAST_SHARE, 5.0)
    if not others.size or share < least_share or farthest < gap * float(others.max()):
        return None
    return Doubt(
        f"{mark:.9g} fills {share:.1%} of the pixels and would be {farthest:.3g} m, while all else is at most "
        f"{others.max():.3g} m: it most likely stands for missing. Give {mark:.9g} as the invalid value, or 0 if it is "
        "depth.",
        invalid=float(mark),
    )


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
