"""Direct solution of the equations of a small grid, in which every cell is tied to a few around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from ..compiling import compiled

Values = NDArray[np.float64]

_LANES = 32
"""Rows are taken off another in multiples of so many columns: whole vectors, with nothing left over."""

_BEYOND = 3 + _LANES
"""Columns of zeros beyond the band, so that four rows can be taken off another at a time, in whole vectors."""


def solve_grid(diagonal: Values, along_x: tuple[Values, ...], along_y: tuple[Values, ...], wanted: Values) -> Values:
    """Solve a symmetric, positive definite system over the cells of a grid.

    Parameters
    ----------
    diagonal : ndarray, shape (H, W)
        Entries of the cells themselves.
    along_x, along_y : tuple of ndarray, shape (H, W)
        Entries between a cell and the next, the one after that, and so on, along x and along y; what would lie beyond
        the grid is 0.
    wanted : ndarray, shape (K, H, W)
        Right-hand sides.

    Returns
    -------
    ndarray of float64, shape (K, H, W)
    """
    height, width = diagonal.shape
    if height < width:  # along the shorter side, the band is narrower
        turned = solve_grid(
            diagonal.T, _transposed(along_y), _transposed(along_x), np.ascontiguousarray(wanted.transpose(0, 2, 1))
        )
        return np.ascontiguousarray(turned.transpose(0, 2, 1))
    cells = diagonal.size
    reach = max(len(along_x), len(along_y) * width)
    band = np.zeros((cells, reach + 1 + _BEYOND))
    band[:, 0] = diagonal.ravel()
    for step, entries in enumerate(along_x, 1):
        band[:, step] += entries.ravel()
    for step, entries in enumerate(along_y, 1):
        band[:, step * width] += entries.ravel()
    found = wanted.reshape(len(wanted), cells).astype(np.float64)
    return _solve_band(band, found).reshape(wanted.shape)


def _transposed(entries: tuple[Values, ...]) -> tuple[Values, ...]:
    return tuple(values.T for values in entries)


def _cholesky(band: Values, found: Values) -> Values:
    cells, width = band.shape
    reach = width - _BEYOND
    entries, lanes = band.reshape(-1), np.uint64(_LANES)  # with indices that have a sign, it is not vectorised
    for i in range(cells):
        row, begun = band[i], np.uint64(i * width)
        k = max(i - reach + 1, 0)
        while k + 3 < i:
            off = i - k
            a, b, c, d = -band[k, off], -band[k + 1, off - 1], -band[k + 2, off - 2], -band[k + 3, off - 3]
            first, step = np.uint64(k * width + off), np.uint64(width - 1)
            second, third, fourth = first + step, first + step + step, first + step + step + step
            length = min(reach - off + 3, reach)
            for j in range(np.uint64((length + _LANES - 1) // _LANES) * lanes):
                entries[begun + j] += (
                    a * entries[first + j] + b * entries[second + j] + c * entries[third + j] + d * entries[fourth + j]
                )
            k += 4
        while k < i:
            off = i - k
            a, above = -band[k, off], band[k, off:reach]
            for j in range(reach - off):
                row[j] += a * above[j]
            k += 1
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
def _solve_band(band: Values, found: Values) -> Values:
    """By Cholesky's factors of the upper band, row by row; both arrays are written over."""
    return solveh_banded(band[:, :-_BEYOND].T, found.T, lower=True, check_finite=False).T
