"""Surfaces through known depth that do without blocks: the thin plate, and colourisation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array, diags_array, vstack
from scipy.sparse.linalg import splu

from ..errors import InputError
from .rims import similar_neighbours

# Sparse linear systems of pixels.

MAX_UNKNOWNS = 3_000_000
"""Larger systems are refused: at this size the factors of a thin plate need about 12 GB."""


def stencil(shape: tuple[int, int], offsets: dict[tuple[int, int], float]) -> csr_array:
    """Matrix of a weighted sum of pixels around each place, for all places where these pixels lie in the image.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the image.
    offsets : dict
        (row, column) >= 0 from the place -> weight.

    Returns
    -------
    csr_array of float64, shape (places, H * W)
    """
    height = shape[0] - max(row for row, _ in offsets)
    width = shape[1] - max(column for _, column in offsets)
    if height <= 0 or width <= 0:
        return csr_array((0, shape[0] * shape[1]), dtype=np.float64)
    pixel = np.arange(shape[0] * shape[1]).reshape(shape)
    columns = [pixel[row : row + height, column : column + width].ravel() for row, column in offsets]
    count = height * width
    return csr_array(
        (np.repeat(list(offsets.values()), count), (np.tile(np.arange(count), len(offsets)), np.concatenate(columns))),
        shape=(count, pixel.size),
    )


def solve(matrix: csc_array, right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a system whose pattern is symmetric and whose diagonal dominates or is that of a positive matrix.

    Raises
    ------
    InputError
        If it is too large to be solved directly.
    """
    if right.size > MAX_UNKNOWNS:
        told = f"{right.size:,} unknown pixels exceed {MAX_UNKNOWNS:,}"
        raise InputError(f"{told}. Use another method, or smaller frames.")
    # without pivoting, the ordering for symmetric patterns keeps the factors ten times as sparse
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return factors.solve(right)


# With too few or collinear known pixels the bending energy does not determine the plate's tilt; this weight of the
# first differences' energy does, and has no visible effect elsewhere.
_LEVELLING = 1e-8


def thin_plate(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """The thin plate: minimises squared second differences, keeps known values.

    Parameters
    ----------
    depth : ndarray of float64, shape (H, W)
        NaN = missing; at least one known value.

    Raises
    ------
    InputError
        If more than `MAX_UNKNOWNS` are missing.
    """
    plane = plane_through(depth)
    return plane + minimise_energy(depth - plane, bending(depth.shape))


def bending(shape: tuple[int, int]) -> csr_array:
    """Second differences of a surface of this shape, along rows, columns and both, as rows of a matrix."""
    return vstack([
        stencil(shape, {(0, 0): 1.0, (0, 1): -2.0, (0, 2): 1.0}),
        stencil(shape, {(0, 0): 1.0, (1, 0): -2.0, (2, 0): 1.0}),
        math.sqrt(2) * stencil(shape, {(0, 0): 1.0, (1, 1): 1.0, (1, 0): -1.0, (0, 1): -1.0}),
        math.sqrt(_LEVELLING) * first_differences(shape),
    ], format="csr")  # fmt: skip


def first_differences(shape: tuple[int, int]) -> csr_array:
    """First differences of a surface of this shape, along rows and columns, as rows of a matrix."""
    across = stencil(shape, {(0, 0): -1.0, (0, 1): 1.0})
    return vstack([across, stencil(shape, {(0, 0): -1.0, (1, 0): 1.0})], format="csr")


def minimise_energy(depth: NDArray[np.float64], differences: csr_array) -> NDArray[np.float64]:
    """Replace NaN in `depth` so that the sum of squares of `differences @ depth` is minimal."""
    missing = np.isnan(depth).ravel()
    if not missing.any():
        return depth
    by_pixel = differences.tocsc()
    free, fixed = by_pixel[:, missing], by_pixel[:, ~missing]
    values = depth.ravel().copy()
    values[missing] = solve((free.T @ free).tocsc(), -(free.T @ (fixed @ values[~missing])))
    return values.reshape(depth.shape)


def plane_through(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least-squares plane of the known pixels, level where they do not determine its tilt."""
    places = np.argwhere(np.isfinite(depth)).astype(np.float64)
    centre = places.mean(axis=0)
    values = depth[np.isfinite(depth)]
    slope = np.linalg.lstsq(places - centre, values - values.mean())[0]
    rows, columns = np.indices(depth.shape)
    return values.mean() + slope[0] * (rows - centre[0]) + slope[1] * (columns - centre[1])


# Colourisation: pixels of similar colour have similar depth.


def colourisation(grey: NDArray[np.float64], depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Levin, Lischinski and Weiss, "Colorization using optimization", 2004, as the NYU Depth toolbox uses it on depth.

    Each value is the mean of its 3x3 neighbours, weighted by similarity of grey level relative to the window's
    variance; known depth is a soft constraint of weight 1 (alpha).

    Parameters
    ----------
    grey : ndarray of float64, shape (H, W)
        Grey levels in [0, 1].
    depth : ndarray of float64, shape (H, W)
        NaN = missing; at least one known value.

    Raises
    ------
    InputError
        If there are more than `MAX_UNKNOWNS` values.
    """
    weights, neighbours = similar_neighbours(grey, np.ones(grey.shape, bool))
    present = weights > 0
    rows = np.broadcast_to(np.arange(grey.size), weights.shape)[present]
    links = csr_array((weights[present], (rows, neighbours[present])), shape=(grey.size, grey.size))
    matrix = diags_array(1.0 + np.isfinite(depth).ravel()) - links
    return solve(matrix.tocsc(), np.nan_to_num(depth).ravel()).reshape(depth.shape)
