"""Penalised least squares by cosine transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn
from scipy.optimize import minimize_scalar

from ...frame import RGBDFrame
from .interpolation import nearest

_MAX_ITERATIONS = 100
_TOLERANCE = 1e-3
_OVER_RELAXATION = 1.75
_START_SHARE = 0.1
_LEVERAGES = (0.99, 1e-6)


def dct_smoothing(frame: RGBDFrame) -> NDArray[np.float64]:
    """Garcia, "Robust smoothing of gridded data in one and higher dimensions with missing values", 2010.

    Smoothness is chosen by generalised cross-validation on the way, missing pixels have weight 0; start, relaxation,
    tolerance and number of iterations are those of the author's program.
    """
    known = frame.known
    data = np.nan_to_num(frame.depth.astype(np.float64))
    roughness = _roughness(frame.shape)
    limits = np.log10([_strength(leverage) for leverage in _LEVERAGES])
    surface = _coarse_start(nearest(frame).astype(np.float64))
    strength = 0.0
    for iteration in range(1, _MAX_ITERATIONS + 1):
        target = dctn(np.where(known, data, surface), norm="ortho")
        # the choice is costly and settles early: only at iterations 1, 2, 4, 8, ...
        if iteration & (iteration - 1) == 0:
            strength = 10 ** _chosen_exponent(target, roughness, data, known, limits)
        smooth = idctn(target / (1 + strength * roughness), norm="ortho")
        relaxed = _OVER_RELAXATION * smooth + (1 - _OVER_RELAXATION) * surface
        change = np.linalg.norm(relaxed - surface) / np.linalg.norm(relaxed)
        surface = relaxed
        if change < _TOLERANCE:
            break
    return np.where(surface > 0, surface, np.nan)


def _roughness(shape: tuple[int, int]) -> NDArray[np.float64]:
    """Squared eigenvalues of the Laplacian, of the shape of the transform."""
    rows, columns = (2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in shape)
    return (rows[:, None] + columns[None, :]) ** 2


def _strength(leverage: float) -> float:
    """The smoothing strength at which a sample in the plane has this much weight in its own estimate."""
    return (((1 + np.sqrt(1 + 8 * leverage)) / 4 / leverage) ** 2 - 1) / 16


def _coarse_start(dense: NDArray[np.float64]) -> NDArray[np.float64]:
    spectrum = dctn(dense, norm="ortho")
    rows, columns = (int(np.ceil(size * _START_SHARE)) for size in dense.shape)
    spectrum[rows:] = 0
    spectrum[:, columns:] = 0
    return idctn(spectrum, norm="ortho")


def _chosen_exponent(
    target: NDArray[np.float64],
    roughness: NDArray[np.float64],
    data: NDArray[np.float64],
    known: NDArray[np.bool_],
    limits: NDArray[np.float64],
) -> float:
    def cross_validation(exponent: float) -> float:
        gain = 1 / (1 + 10**exponent * roughness)
        residual = (data - idctn(target * gain, norm="ortho"))[known]
        return float(np.mean(residual**2) / (1 - np.mean(gain)) ** 2)

    found = minimize_scalar(cross_validation, bounds=tuple(limits), method="bounded", options={"xatol": 0.1})
    return float(found.x)
