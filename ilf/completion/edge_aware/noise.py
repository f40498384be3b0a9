"""Noise of a frame's depth, estimated from the depth itself: its size by depth, quantisation and correlation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from ..._runtime.long_work import check_cancelled
from ...data.frame import RGBDFrame
from ...data.frame_cache import once_per_frame

Array = NDArray[np.float32]

_LAG = 6
"""Distance [px] of second differences: large enough that noise correlated between neighbours is fully included."""

_AVERAGED = 9
"""Side [px] of the squares whose mean depth assigns a pixel to a range, independent of its own noise."""

_RANGES, _LEAST = 16, 50
"""Number of depth ranges with about equally many pixels, and the minimum number of pixels of each."""

_SHARED = 3
"""Maximum distance [px] of correlated noise."""

_OUTLYING = 3.0
"""Differences of more standard deviations belong to surfaces and are ignored for the correlation of noise."""

_NORMAL_MAD = 0.6745
"""Median absolute deviation of a normal distribution, in standard deviations."""

_OF_SECOND = math.sqrt(6.0)
"""Standard deviation of second differences of independent noise, relative to that of the noise."""

_LEAST_DEVIATION = 1e-5
"""Minimum noise [m]: exact depth has rounding."""


@dataclass(frozen=True)
class Noise:
    """Noise of depth z: standard deviation `constant` + `quadratic` z^2, as for stereo and structured light.

    Attributes
    ----------
    constant : float
        [m].
    quadratic : float
        [1 / m].
    grain : float
        Number of pixels with correlated noise, at least 1: the variance of the mean of n pixels is `grain` / n times
        that of one.
    """

    constant: float
    quadratic: float = 0.0
    grain: float = 1.0

    @property
    def note(self) -> str:
        """A sentence on it for the user."""
        near, far = (1000 * (self.constant + self.quadratic * z * z) for z in (1, 4))
        found = f"{near:.2g} mm" if self.quadratic == 0 else f"{near:.2g} mm at 1 m and {far:.2g} mm at 4 m"
        return f"Noise estimated from the known depth: standard deviation {found}."

    def deviation(self, depth: NDArray[np.floating]) -> Array:
        """Standard deviation [m] at these depths [m]; only the constant part where depth is missing."""
        far = np.nan_to_num(np.asarray(depth, np.float32), nan=0.0)
        return np.maximum(self.constant + self.quadratic * far * far, _LEAST_DEVIATION).astype(np.float32)


@once_per_frame
def frame_noise(frame: RGBDFrame) -> Noise:
    """Estimate the noise of a frame's depth, including quantisation."""
    depth = frame.depth
    around = _mean_depth(depth)
    seconds = [_seconds(depth), _seconds(depth.T).T]
    size, at = (np.concatenate(parts) for parts in zip(*(_found(values, around) for values in seconds), strict=True))
    if size.size < _LEAST:
        return Noise(0.0)
    check_cancelled()
    steps_at, steps = _steps(depth)
    deviations, depths = [], []
    order = np.argsort(at)
    for members in np.array_split(order, min(_RANGES, size.size // _LEAST)):
        z = float(np.median(at[members]))
        spread = float(np.median(size[members])) / _NORMAL_MAD / _OF_SECOND
        deviations.append(max(spread, float(np.interp(z, steps_at, steps)) / math.sqrt(12), _LEAST_DEVIATION))
        depths.append(z)
    check_cancelled()
    found = np.array(deviations)
    # fit relative errors; noise does not decrease with depth
    terms = np.stack([np.ones(found.size), np.square(depths)], axis=1) / found[:, None]
    (constant, quadratic), _ = nnls(terms, np.ones(found.size))
    noise = Noise(float(constant), float(quadratic))
    return Noise(noise.constant, noise.quadratic, _grain([values / noise.deviation(around) for values in seconds]))


def _seconds(depth: Array) -> Array:
    """Second differences along rows, NaN where a pixel of the three is missing, shape (H, W)."""
    found = np.full(depth.shape, np.nan, np.float32)
    found[:, _LAG:-_LAG] = depth[:, : -2 * _LAG] - 2 * depth[:, _LAG:-_LAG] + depth[:, 2 * _LAG :]
    return found


def _found(seconds: Array, around: Array) -> tuple[Array, Array]:
    """Absolute second differences and the local mean depth, on every other row and column."""
    values = seconds[::2, ::2]
    known = np.isfinite(values)
    return np.abs(values[known]), around[::2, ::2][known]


def _mean_depth(depth: Array) -> Array:
    """Local mean of the known depth; 0 where there is none."""
    known = np.isfinite(depth)
    share, total = (
        cv2.blur(values, (_AVERAGED, _AVERAGED), borderType=cv2.BORDER_REFLECT)
        for values in (known.astype(np.float32), np.where(known, depth, np.float32(0)))
    )
    return np.divide(total, share, out=np.zeros_like(total), where=share > 0.5 / _AVERAGED**2)


def _steps(depth: Array) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """Depths, and the mean distance [m] of neighbouring depth values there, weighted by frequency."""
    values, counts = np.unique(depth[np.isfinite(depth)][::4], return_counts=True)
    if values.size < 2:
        return np.zeros(1), np.zeros(1)
    gaps, weights = np.diff(values), np.minimum(counts[1:], counts[:-1])
    parts = np.array_split(np.arange(gaps.size), min(_RANGES, gaps.size))
    found = [float(np.average(gaps[part], weights=weights[part])) for part in parts]
    return np.array([values[part[0]] for part in parts]), np.array(found)


def _grain(seconds: list[Array]) -> float:
    """Sum of the correlations of noise with that of the pixels around, from normalised second differences."""
    totals, squares = 0.0, 0.0
    for values in seconds:
        of_noise = np.abs(values) < _OUTLYING * _OF_SECOND
        inside = np.where(of_noise, values, np.float32(0))
        height, width = inside.shape
        own = float(np.square(inside).sum(dtype=np.float64)) / max(int(of_noise.sum()), 1)
        shared = 0.0
        for dy in range(_SHARED + 1):
            for dx in range(-_SHARED, _SHARED + 1):
                if (dy, dx) <= (0, 0):
                    continue  # every pair once
                here = np.s_[: height - dy, max(0, -dx) : min(width, width - dx)]
                there = np.s_[dy:, max(0, dx) : min(width, width + dx)]
                pairs = max(int((of_noise[here] & of_noise[there]).sum()), 1)
                shared += 2 * float((inside[here] * inside[there]).sum(dtype=np.float64)) / pairs
        totals, squares = totals + own + shared, squares + own
    return max(totals / squares, 1.0) if squares > 0 else 1.0
