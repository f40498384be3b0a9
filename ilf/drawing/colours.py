"""Values to 8-bit indices of colour maps, colour ranges, and the spectrum of a block's depth."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft
from numpy.typing import NDArray

_SAMPLES = 50_000
_SMALLEST_DIFFERENCE = 1.0


def to_indices(values: NDArray[np.floating], low: float, high: float) -> NDArray[np.uint8]:
    """Indices 1-255 for values from low to high (others are clipped), 0 for NaN (missing)."""
    scaled = (values - np.float32(low)) * np.float32(254 / (high - low))
    np.clip(scaled, 0, 254, out=scaled)
    scaled += np.float32(1.5)
    scaled[np.isnan(scaled)] = 0
    return scaled.astype(np.uint8)


def log_indices(error: NDArray[np.floating], levels: tuple[float, float]) -> NDArray[np.uint8]:
    """Indices 1-255 of errors [m] on a logarithmic colour range [mm], 0 for NaN (missing)."""
    indices = np.zeros(error.shape, np.uint8)
    known = np.isfinite(error)
    low, high = np.log(levels)
    indices[known] = to_indices(np.log(error[known] * np.float32(1000)), low, high)
    return indices


def robust_depth_levels(depth: NDArray[np.floating]) -> tuple[float, float]:
    """Robust colour range of depth: 1st and 99th percentile of the known depth [m]; (0, 1) if none is known."""
    low, high = _most_of(depth, (0.0, 1.0))
    return (low, high) if high - low > 1e-3 else (low - 0.05, high + 0.05)


def robust_error_levels(error: NDArray[np.floating]) -> tuple[float, float]:
    """Robust colour range [mm] of errors, logarithmic: 1st and 99th percentile, widened to 1, 2 or 5 times a power of
    ten."""
    low, high = _most_of(error, (1.0, 10.0))
    low, high = 1 / round_up(1 / low), round_up(high)
    return low, max(high, 10 * low)


def _most_of(values: NDArray[np.floating], otherwise: tuple[float, float]) -> tuple[float, float]:
    """1st and 99th percentile of the known values, if there are any."""
    known = _known_sample(values)
    low, high = np.percentile(known, (1, 99)).tolist() if known.size else otherwise
    return low, high


def robust_difference_level(difference: NDArray[np.floating], percent: float = 99) -> float:
    """End of a robust symmetric colour range [mm]: this percentile of the magnitudes, rounded up to 1, 2 or 5 times a
    power of ten.

    The rounding keeps the colours stable while a run refreshes the view.
    """
    known = _known_sample(difference)
    level = float(np.percentile(np.abs(known), percent)) if known.size else 0.0
    if level <= _SMALLEST_DIFFERENCE:
        return _SMALLEST_DIFFERENCE
    return round_up(level)


def round_up(value: float) -> float:
    """Round up to 1, 2 or 5 times a power of ten. Applied to the inverse, its inverse rounds down."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= value * (1 - 1e-6))


def sample(values: NDArray[np.floating]) -> NDArray[np.floating]:
    """About `_SAMPLES` evenly spaced values of an array: enough for percentiles, fast enough for live refresh.

    Arrays of the same shape are sampled at the same positions; a sample is returned whole.
    """
    flat = values.ravel()
    # an odd stride avoids aliasing with even image widths
    return flat[:: (flat.size // _SAMPLES) | 1]


def _known_sample(values: NDArray[np.floating]) -> NDArray[np.floating]:
    few = sample(values)
    return few[np.isfinite(few)]


# The spectrum of a block's depth, for display with the pass band.


def depth_spectrum(depth: NDArray[np.floating], padding: float, reach: tuple[int, int]) -> NDArray[np.float32]:
    """Log magnitude of the spectrum of a block's depth on the padded grid, with wave number 0 in the middle.

    The mean of the known depth, which would dominate the spectrum, is subtracted; missing pixels count as 0.

    Parameters
    ----------
    depth : ndarray of float, shape (h, w)
        Depth on the block's bounding box [m], NaN outside the block and where it is missing.
    padding : float
        Ratio of the grid's sides to those of the bounding box, as in `Parameters.padding`.
    reach : tuple of int
        Largest wave numbers (k_y, k_x) that are kept, in cycles per grid.

    Returns
    -------
    ndarray of float32
        In [0, 1]. Row k_y + rows // 2 and column k_x + columns // 2 contain wave number (k_y, k_x).

    Examples
    --------
    >>> import numpy as np
    >>> waves = 2 + np.cos(2 * np.pi * 3 * np.arange(32) / 32) * np.ones((32, 1))
    >>> spectrum = depth_spectrum(waves, 1.0, (2, 5))
    >>> spectrum.shape, np.flatnonzero(spectrum[2] > 0.5).tolist()
    ((5, 11), [2, 8])
    """
    known = np.isfinite(depth)
    values = np.where(known, depth - (depth[known].mean() if known.any() else 0.0), 0.0)
    grid = tuple(math.ceil(padding * side) for side in depth.shape)
    magnitude = np.fft.fftshift(np.log1p(np.abs(scipy.fft.fft2(values, s=grid))))
    rows, columns = (
        slice(max(side // 2 - most, 0), side // 2 + most + 1) for side, most in zip(magnitude.shape, reach, strict=True)
    )
    magnitude = magnitude[rows, columns]
    low, high = float(magnitude.min()), float(magnitude.max())
    if high <= low:
        return np.zeros(magnitude.shape, np.float32)
    return ((magnitude - low) / (high - low)).astype(np.float32)
