"""Quality of the expected error, given the true errors: the share within it, and its ranking of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.floating]


def share_within(error: Values, expected: Values, times: float = 1.0) -> float:
    """Compute the share of the errors, 0-1, that are at most `times` the expected ones.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True errors (signed) and expected errors (positive) [m]; at least one.
    times : float

    Examples
    --------
    >>> share_within(np.array([0.1, -0.3, 0.5]), np.array([0.2, 0.2, 0.2]))
    0.3333333333333333
    """
    return float(np.mean(np.abs(error) <= times * expected))


def sparsification_error(error: Values, expected: Values) -> float:
    """Compute the area between the sparsification curves of the expected and of the true errors: 0 is perfect.

    Pixels are removed one by one, those with the largest expected error first, and the RMSE of the rest is computed
    each time; likewise by their true errors, which is the optimal order. The result is the mean difference of these two
    curves over the RMSE of all pixels. A random order has 0.6 for normally distributed errors, and more if few are
    large. It depends only on the order of the expected errors, not on their size.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True errors (signed) and expected errors (positive) [m]; at least one. Pixels with equal expected errors have
        the mean of their squared errors.

    Examples
    --------
    >>> error = np.array([0.1, 0.2, 0.4])
    >>> sparsification_error(error, error), round(sparsification_error(error, 1 - error), 2)
    (0.0, 0.58)
    """
    squares = np.square(error, dtype=np.float64)
    _, ranks, counts = np.unique(expected, return_inverse=True, return_counts=True)
    by_expected = np.repeat(np.bincount(ranks, squares) / counts, counts)
    total = float(np.sqrt(squares.mean()))
    if total == 0:
        return 0.0
    return float(np.mean(_rmse_of_first(by_expected) - _rmse_of_first(np.sort(squares)))) / total


def _rmse_of_first(squares: NDArray[np.float64]) -> NDArray[np.float64]:
    """RMSE of the first, the first two, ... of some squared errors."""
    return np.sqrt(np.cumsum(squares) / np.arange(1, squares.size + 1))
