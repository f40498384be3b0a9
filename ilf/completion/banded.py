"""Direct solution of symmetric, positive definite systems in which every unknown is coupled to a few that follow.

No BLAS: on several threads, its factors differ in the last bits, and its threads spin while they wait.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded

from .._runtime.compiling import compiled

Values = NDArray[np.float64]

_LANES = 16
"""Rows are subtracted in multiples of this many columns: whole vectors, without a remainder."""

_BEYOND = 3 + _LANES
"""Columns of zeros beyond the band, so that four rows can be subtracted at a time, in whole vectors."""


def empty_band(cells: int, reach: int) -> Values:
    """Make the array for `solve_band`, all 0, float64 (N, R + 20): column k of row i is for the matrix entry
    (i, i + k), with k up to R, the reach."""
    return np.zeros((cells, reach + 1 + _BEYOND))


def solve_grid(diagonal: Values, along_x: tuple[Values, ...], along_y: tuple[Values, ...], wanted: Values) -> Values:
    """Solve a symmetric, positive definite system over the cells of a grid.

    Parameters
    ----------
    diagonal : ndarray, shape (H, W)
        Diagonal entries.
    along_x, along_y : tuple of ndarray, shape (H, W)
        Entries between a cell and the next, the one after that, and so on, along x and along y; 0 beyond the grid.
    wanted : ndarray, shape (K, H, W)
        Right-hand sides.

    Returns
    -------
    ndarray of float64, shape (K, H, W)
    """
    height, width = diagonal.shape
    if height < width:  # the band is narrower along the shorter side
        turned_x, turned_y = (tuple(entries.T for entries in along) for along in (along_y, along_x))
        turned = solve_grid(diagonal.T, turned_x, turned_y, np.ascontiguousarray(wanted.transpose(0, 2, 1)))
        return np.ascontiguousarray(turned.transpose(0, 2, 1))
    cells = diagonal.size
    reach = max(len(along_x), len(along_y) * width)
    band = empty_band(cells, reach)
    band[:, 0] = diagonal.ravel()
    for step, entries in enumerate(along_x, 1):
        band[:, step] += entries.ravel()
    for step, entries in enumerate(along_y, 1):
        band[:, step * width] += entries.ravel()
    found = wanted.reshape(len(wanted), cells).astype(np.float64)
    return solve_band(band, found).reshape(wanted.shape)


def solve_linked(along_x: NDArray[np.floating], along_y: NDArray[np.floating], held: Values, wanted: Values) -> Values:
    """Solve for values on a grid whose cells are linked to their four neighbours and held at 0: the matrix is that of
    sum held u^2 + sum conductance (u_next - u)^2.

    Parameters
    ----------
    along_x, along_y : ndarray, shapes (H, W - 1) and (H - 1, W)
        Conductances of the links.
    held : ndarray of float64, shape (H, W)
        Weight with which each cell is held; positive.
    wanted : ndarray of float64, shape (K, H, W)
        Right-hand sides.

    Returns
    -------
    ndarray of float64, shape (K, H, W)
    """
    right, below = np.zeros_like(held), np.zeros_like(held)
    right[:, :-1], below[:-1] = along_x, along_y
    diagonal = held + right + below
    diagonal[:, 1:] += right[:, :-1]
    diagonal[1:] += below[:-1]
    return solve_grid(diagonal, (-right,), (-below,), wanted)


def _cholesky(band: Values, found: Values) -> Values:
    cells, width = band.shape
    reach = width - _BEYOND
    entries, lanes = band.reshape(-1), np.uint64(_LANES)  # signed indices are not vectorised
    above = 0
    for i in range(cells):
        row = band[i]
        if i % 2 == 0:  # from this row and the next, which read the same of the rows above, four at a time
            above = max(i - reach + 1, 0)
            upper, lower = np.uint64(i * width + 1), np.uint64((i + 1) * width)
            while above + 3 < i and i + 1 < cells:
                off, k = i - above, above
                a, b, c, d = -band[k, off], -band[k + 1, off - 1], -band[k + 2, off - 2], -band[k + 3, off - 3]
                e, f, g, h = -band[k, off + 1], -band[k + 1, off], -band[k + 2, off - 1], -band[k + 3, off - 2]
                row[0] -= a * a + b * b + c * c + d * d
                first, step = np.uint64(k * width + off + 1), np.uint64(width - 1)
                second, third, fourth = first + step, first + step + step, first + step + step + step
                length = min(reach - off + 2, reach - 1)
                for j in range(np.uint64((length + _LANES - 1) // _LANES) * lanes):
                    p, q, r, s = entries[first + j], entries[second + j], entries[third + j], entries[fourth + j]
                    entries[upper + j] += a * p + b * q + c * r + d * s
                    entries[lower + j] += e * p + f * q + g * r + h * s
                above += 4
        for k in range(above, i):
            factor, rest = -band[k, i - k], band[k, i - k : reach]
            for j in range(reach - (i - k)):
                row[j] += factor * rest[j]
        scale = 1 / np.sqrt(row[0])
        for j in range(reach):
            row[j] *= scale
    for side in found:
        for i in range(cells):
            row = band[i]
            length = min(reach, cells - i)
            ahead = side[i : i + length]
            ahead[0] /= row[0]
            here = ahead[0]
            for j in range(1, length):
                ahead[j] -= row[j] * here
        for i in range(cells - 1, -1, -1):
            row = band[i]
            length = min(reach, cells - i)
            ahead = side[i : i + length]
            total = 0.0
            for j in range(1, length):
                total += row[j] * ahead[j]
            side[i] = (side[i] - total) / row[0]
    return found


@compiled(_cholesky)
def solve_band(band: Values, found: Values) -> Values:
    """Solve by Cholesky factorisation, row by row.

    Parameters
    ----------
    band : ndarray of float64, shape (N, R + 20)
        From `empty_band`, filled in; overwritten.
    found : ndarray of float64, shape (K, N)
        Right-hand sides; overwritten.

    Returns
    -------
    ndarray of float64, shape (K, N)
        NaN if rounding leaves the matrix not positive definite.
    """
    cells, reach = len(band), band.shape[1] - _BEYOND
    # with zeros before and beyond, every row has the same number of rows above it, each shifted by one
    wide = np.zeros((cells + reach, 2 * reach))
    wide[reach:, :reach] = band[:, :reach]
    down, right = wide.strides
    rows_above = as_strided(wide[1:, reach - 1 :], (cells, reach - 1, reach), (down, down - right, right))
    for row, above in zip(wide[reach:, :reach], rows_above, strict=True):
        row -= np.einsum("i,ij->j", above[:, 0], above)
        row /= math.sqrt(row[0]) if row[0] > 0 else math.nan
    return cho_solve_banded((wide[reach:, :reach].T, True), found.T, check_finite=False).T
