"""Numbers to 8-bit indices for lookup tables, and the levels between which they lie."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_SAMPLES = 50_000
_SMALLEST_DIFFERENCE = 1.0


def to_indices(values: NDArray[np.floating], low: float, high: float) -> NDArray[np.uint8]:
    """Indices 1-255 for values from low to high (beyond: the ends), 0 for NaN (missing)."""
    scaled = (values - np.float32(low)) * np.float32(254 / (high - low))
    np.clip(scaled, 0, 254, out=scaled)
    scaled += np.float32(1.5)
    scaled[np.isnan(scaled)] = 0
    return scaled.astype(np.uint8)


def log_indices(error: NDArray[np.floating], levels: tuple[float, float]) -> NDArray[np.uint8]:
    """Indices 1-255 of errors [m] on a logarithmic scale between two levels [mm], 0 for NaN (missing)."""
    indices = np.zeros(error.shape, np.uint8)
    known = np.isfinite(error)
    low, high = np.log(levels)
    indices[known] = to_indices(np.log(error[known] * np.float32(1000)), low, high)
    return indices


def robust_depth_levels(depth: NDArray[np.floating]) -> tuple[float, float]:
    """1st and 99th percentile of the known depth [m]; (0, 1) where nothing is known."""
    known = _known_sample(depth)
    if known.size == 0:
        return 0.0, 1.0
    low, high = (float(level) for level in np.percentile(known, (1, 99)))
    return (low, high) if high - low > 1e-3 else (low - 0.05, high + 0.05)


def robust_error_levels(error: NDArray[np.floating]) -> tuple[float, float]:
    """Levels [mm] of a logarithmic scale: 1st and 99th percentile, widened to 1, 2 or 5 times a power of ten."""
    known = _known_sample(error)
    if known.size == 0:
        return 1.0, 10.0
    low, high = (float(level) for level in np.percentile(known, (1, 99)))
    low, high = 1 / _round_up(1 / low), _round_up(high)
    return low, max(high, 10 * low)


def robust_difference_level(difference: NDArray[np.floating]) -> float:
    """Symmetric level [mm]: 99th percentile of the magnitudes, rounded up to 1, 2 or 5 times a power of ten.

    The rounding keeps the colours steady while a run refreshes the view.
    """
    known = _known_sample(difference)
    level = float(np.percentile(np.abs(known), 99)) if known.size else 0.0
    if level <= _SMALLEST_DIFFERENCE:
        return _SMALLEST_DIFFERENCE
    return _round_up(level)


def _round_up(value: float) -> float:
    """The next 1, 2 or 5 times a power of ten. Its inverse, of an inverse, is the one before."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-6))


def sample(values: NDArray[np.floating]) -> NDArray[np.floating]:
    """About `_SAMPLES` of an array's values, spread evenly: enough for percentiles, quick enough for live refresh.

    Arrays of one shape give values of the same places; of what was sampled, all is taken.
    """
    flat = values.ravel()
    # an odd stride does not fall in step with even image widths
    return flat[:: (flat.size // _SAMPLES) | 1]


def _known_sample(values: NDArray[np.floating]) -> NDArray[np.floating]:
    few = sample(values)
    return few[np.isfinite(few)]
