"""Penalised least squares by cosine transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from ...frame import RGBDFrame
from .interpolation import nearest

_STRENGTHS = np.logspace(3, -6, 100)
_OVER_RELAXATION = 2.0


def dct_smoothing(frame: RGBDFrame) -> NDArray[np.float64]:
    """Garcia, "Robust smoothing of gridded data in one and higher dimensions with missing values", 2010.

    In its form for gaps in reliable data (Wang, Garcia et al., "A three-dimensional gap filling method for large
    geophysical datasets", 2012), with the strengths, number of steps and relaxation of the authors' program: the
    smoothness weakens from step to step, and known depth is put back after each. Smoothing once and for all with the
    strength that cross-validation chooses gave larger errors, in gaps of both kinds.
    """
    known = frame.known
    surface = nearest(frame).astype(np.float64)
    data = surface[known]
    roughness = _roughness(frame.shape)
    for strength in _STRENGTHS:
        smooth = idctn(dctn(surface, norm="ortho") / (1 + strength * roughness), norm="ortho")
        surface += _OVER_RELAXATION * (smooth - surface)
        surface[known] = data
    return np.where(surface > 0, surface, np.nan)


def _roughness(shape: tuple[int, int]) -> NDArray[np.float64]:
    """Squared eigenvalues of the Laplacian, of the shape of the transform."""
    rows, columns = (2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in shape)
    return (rows[:, None] + columns[None, :]) ** 2
