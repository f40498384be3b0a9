"""Surfaces of least energy through the known pixels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, vstack

from ...frame import RGBDFrame
from .sparse import solve, stencil

# With too few or collinear known pixels the bending energy does not say how the plate is tilted; this much of the
# first differences' energy does, and changes nothing that can be seen elsewhere.
_LEVELLING = 1e-8

# of 0, 0.1, 1, 10 and 100 the one of least error over large areas of eight frames; among dense samples 0 is better
_STIFFNESS = 10.0


def laplace(frame: RGBDFrame) -> NDArray[np.float64]:
    """The harmonic surface: least squared first differences, known pixels as they are."""
    return _least_energy(frame.depth.astype(np.float64), _first_differences(frame.shape))


def thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate: least squared second differences, known pixels as they are."""
    depth = frame.depth.astype(np.float64)
    plane = _plane_through(depth)
    surface = plane + _least_energy(depth - plane, _bending(frame.shape))
    return np.where(surface > 0, surface, np.nan)


def soft_thin_plate(frame: RGBDFrame) -> NDArray[np.float64]:
    """The thin plate as a Gaussian Markov random field: it smooths the known pixels instead of passing through them.

    Noise at the rims of large holes then tilts it less. Minimises the squared misfit of the known pixels plus
    `_STIFFNESS` times the squared second differences.
    """
    depth = frame.depth.astype(np.float64)
    plane = _plane_through(depth)
    bending = _bending(frame.shape)
    known = diags_array(frame.known.ravel().astype(np.float64))
    misfit = np.nan_to_num(depth - plane).ravel()
    surface = plane + solve((_STIFFNESS * (bending.T @ bending) + known).tocsc(), misfit).reshape(frame.shape)
    return np.where(surface > 0, surface, np.nan)


def _bending(shape: tuple[int, int]) -> csr_array:
    return vstack([
        stencil(shape, {(0, 0): 1.0, (0, 1): -2.0, (0, 2): 1.0}),
        stencil(shape, {(0, 0): 1.0, (1, 0): -2.0, (2, 0): 1.0}),
        math.sqrt(2) * stencil(shape, {(0, 0): 1.0, (1, 1): 1.0, (1, 0): -1.0, (0, 1): -1.0}),
        math.sqrt(_LEVELLING) * _first_differences(shape),
    ], format="csr")  # fmt: skip


def _first_differences(shape: tuple[int, int]) -> csr_array:
    across = stencil(shape, {(0, 0): -1.0, (0, 1): 1.0})
    return vstack([across, stencil(shape, {(0, 0): -1.0, (1, 0): 1.0})], format="csr")


def _least_energy(depth: NDArray[np.float64], differences: csr_array) -> NDArray[np.float64]:
    """`depth` with NaN replaced so that the sum of squares of `differences @ depth` is least."""
    missing = np.isnan(depth).ravel()
    if not missing.any():
        return depth
    by_pixel = differences.tocsc()
    free, fixed = by_pixel[:, missing], by_pixel[:, ~missing]
    values = depth.ravel().copy()
    values[missing] = solve((free.T @ free).tocsc(), -(free.T @ (fixed @ values[~missing])))
    return values.reshape(depth.shape)


def _plane_through(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least-squares plane of the known pixels, level where they do not say how it is tilted."""
    places = np.argwhere(np.isfinite(depth)).astype(np.float64)
    centre = places.mean(axis=0)
    values = depth[np.isfinite(depth)]
    slope = np.linalg.lstsq(places - centre, values - values.mean())[0]
    rows, columns = np.indices(depth.shape)
    return values.mean() + slope[0] * (rows - centre[0]) + slope[1] * (columns - centre[1])
