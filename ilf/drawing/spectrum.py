"""The spectrum of a block's depth, as it is looked at beside the pass band that filtered it."""

from __future__ import annotations

import math

import numpy as np
import scipy.fft
from numpy.typing import NDArray


def depth_spectrum(
    depth: NDArray[np.floating], padding: float, reach: tuple[int, int] | None = None
) -> NDArray[np.float32]:
    """Log magnitude of the spectrum of a block's depth on the padded grid, with wave number 0 in the middle.

    The mean of the known depth is taken off, and what is missing counts as 0: the mean alone would outshine the rest.

    Parameters
    ----------
    depth : ndarray of float, shape (h, w)
        Depth on the block's bounding box [m], NaN outside the block and where it is missing.
    padding : float
        Side of the grid in sides of the bounding box, as in `Parameters.padding`.
    reach : tuple of int, optional
        Largest wave numbers (k_y, k_x) that are kept, in cycles per grid; all if left out.

    Returns
    -------
    ndarray of float32
        In [0, 1]. In row k_y + rows // 2 and column k_x + columns // 2 there is wave number (k_y, k_x).

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
    if reach is not None:
        rows, columns = (
            slice(max(side // 2 - most, 0), side // 2 + most + 1)
            for side, most in zip(magnitude.shape, reach, strict=True)
        )
        magnitude = magnitude[rows, columns]
    low, high = float(magnitude.min()), float(magnitude.max())
    if high <= low:
        return np.zeros(magnitude.shape, np.float32)
    return ((magnitude - low) / (high - low)).astype(np.float32)
