"""How good an expected error is, once the true errors are known: how many lie within it, and how it ranks pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.floating]


def share_within(error: Values, expected: Values, times: float = 1.0) -> float:
    """Share of the errors, 0-1, that are at most so many times the expected ones.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True and expected errors [m], of either sign and positive; at least one.
    times : float

    Examples
    --------
    >>> share_within(np.array([0.1, -0.3, 0.5]), np.array([0.2, 0.2, 0.2]))
    0.3333333333333333
    """
    return float(np.mean(np.abs(error) <= times * expected))


def sparsification_error(error: Values, expected: Values) -> float:
    """How much worse than the true errors the expected ones say which pixels to do without: 0 is perfect.

    Pixels leave one by one, those with the largest expected error first, and the RMSE of the rest is taken each time;
    so is that of pixels that leave by their true errors, which no other order can beat. The mean difference of these
    two curves, over the RMSE of all pixels, is what is told. An order without any sense has 0.6 where errors are
    normal, and more where few are large. It depends on the order of the expected errors alone, not on their size.

    Parameters
    ----------
    error, expected : ndarray of float, shape (N,)
        True and expected errors [m], of either sign and positive; at least one. Pixels of the same expected error leave
        together: their squared errors are taken for the mean of them.

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
