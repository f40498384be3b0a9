"""G_i: the ideal elliptical low-pass filter on the half spectrum of a real transform."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_ROUNDING = 1e-9


def squared_wave_numbers(grid: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """k_y^2 as a column and k_x^2 as a row, in the layout of `scipy.fft.rfft2` over a grid (H, W)."""
    height, width = grid
    k_y = np.minimum(np.arange(height), height - np.arange(height)).astype(np.float64)
    k_x = np.arange(width // 2 + 1, dtype=np.float64)
    return (k_y**2)[:, None], (k_x**2)[None, :]


def inside_ellipse(
    squared: tuple[NDArray[np.float64], NDArray[np.float64]], radii: tuple[float, float]
) -> NDArray[np.bool_]:
    """Pass band (k_y / r_y)^2 + (k_x / r_x)^2 <= 1, bool (H, W // 2 + 1).

    Wave numbers on the rim count as inside, however their radii were rounded. A radius of 0 lets only k = 0
    through in that direction.
    """
    rows, columns = (
        k2 / radius**2 if radius > 0 else np.where(k2 > 0, np.inf, 0.0)
        for k2, radius in zip(squared, radii, strict=True)
    )
    return rows + columns <= 1.0 + _ROUNDING
