"""Sparse linear systems of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from ...errors import InputError

MAX_UNKNOWNS = 3_000_000
"""Larger systems are refused: at this size the factors of a thin plate take about 12 GB."""


def stencil(shape: tuple[int, int], offsets: dict[tuple[int, int], float]) -> csr_array:
    """Matrix of a weighted sum of pixels around each place, over all places where these pixels are in the image.

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
        raise InputError(f"{right.size} unknown pixels are too many for a direct solution (at most {MAX_UNKNOWNS}).")
    # without pivoting, the ordering for symmetric patterns keeps the factors ten times as sparse
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return factors.solve(right)
