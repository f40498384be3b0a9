"""Measures of completed depth against ground truth (section 7). Metres throughout."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted, grouped
from ..errors import InputError

DELTA_BASE = 1.25
"""Base of the threshold accuracies delta < 1.25^k."""


@dataclass(frozen=True)
class ErrorMeasures:
    """Errors of depth against ground truth over a set of pixels. The error of a pixel is depth - ground truth.

    Attributes
    ----------
    pixels : int
        Number of pixels compared.
    rmse, mae : float
        Root mean square error [m], Eq. (5), and mean absolute error [m], Eq. (6).
    median : float
        Median absolute error [m].
    rel : float
        Mean of |error| / ground truth, Eq. (7).
    delta : tuple of float
        Shares of pixels with max(depth / ground truth, ground truth / depth) < 1.25^k, for k = 1, 2, 3.
    acc : float
        Accuracy ACC, Eq. (3): the mean error [m], with its sign.
    prs : float
        Precision PRS, Eq. (4): the standard deviation of the error [m], over N and not N - 1 pixels. As printed,
        Eq. (4) squares the sum of the deviations, which is always 0; here, the deviations are squared.
    """

    pixels: int
    rmse: float
    mae: float
    median: float
    rel: float
    delta: tuple[float, float, float]
    acc: float
    prs: float


def measure_errors(
    depth: NDArray[np.floating], ground_truth: NDArray[np.floating], mask: NDArray[np.bool_]
) -> ErrorMeasures:
    """Compare depth with ground truth over a mask.

    Parameters
    ----------
    depth : ndarray of float, shape (H, W)
        Completed depth [m].
    ground_truth : ndarray of float, shape (H, W)
        Ground-truth depth [m].
    mask : ndarray of bool, shape (H, W)
        The pixels to compare; both depths must be known and positive there.

    Raises
    ------
    InputError
        If shapes differ, the mask is empty, or a depth under it is missing.

    Examples
    --------
    >>> ground_truth = np.full((1, 4), 2.0)
    >>> depth, where = ground_truth + [[0.0, 0.2, -0.2, 1.0]], np.array([[True, True, True, False]])
    >>> errors = measure_errors(depth, ground_truth, where)
    >>> errors.pixels, round(errors.rmse, 3), round(errors.mae, 3), round(errors.acc, 3)
    (3, 0.163, 0.133, 0.0)
    """
    shapes = depth.shape, ground_truth.shape, mask.shape
    if len(set(shapes)) > 1:
        raise InputError(f"Depth, ground truth and mask must have the same shape, not {shapes}.")
    measured, true = depth[mask].astype(np.float64), ground_truth[mask].astype(np.float64)
    if measured.size == 0:
        raise InputError("No pixel is selected for the comparison with ground truth. Give a mask with pixels.")
    for name, values in (("depth", measured), ("ground truth", true)):
        lacking = np.count_nonzero(~(np.isfinite(values) & (values > 0)))
        if lacking:
            missing = f"{grouped(lacking)} of {counted(values.size, 'compared pixel')}"
            raise InputError(f"The {name} is missing at {missing}. Restrict the mask to known depth.")
    error = measured - true
    size = np.abs(error)
    ratio = np.maximum(measured / true, true / measured)
    delta_1, delta_2, delta_3 = (float(np.mean(ratio < DELTA_BASE**power)) for power in (1, 2, 3))
    return ErrorMeasures(
        pixels=error.size,
        rmse=float(np.sqrt(np.mean(error**2))),
        mae=float(np.mean(size)),
        median=float(np.median(size)),
        rel=float(np.mean(size / true)),
        delta=(delta_1, delta_2, delta_3),
        acc=float(np.mean(error)),
        prs=float(np.std(error)),
    )


def fill_rate(depth: NDArray[np.floating], wanted: NDArray[np.bool_]) -> float:
    """Compute the share of the wanted pixels that have depth, 0-1.

    Parameters
    ----------
    depth : ndarray of float, shape (H, W)
        Depth [m]; values that are not finite and positive are missing.
    wanted : ndarray of bool, shape (H, W)
        Pixels that should have depth, usually those that were missing before.

    Raises
    ------
    InputError
        If shapes differ or no pixel is wanted.

    Examples
    --------
    >>> fill_rate(np.array([[1.5, np.nan, 2.0]]), np.array([[False, True, True]]))
    0.5
    """
    if depth.shape != wanted.shape:
        raise InputError(f"Depth {depth.shape} and mask {wanted.shape} must have the same shape.")
    values = depth[wanted]
    if values.size == 0:
        raise InputError("No pixel is wanted, so the fill rate is undefined. Give a mask with pixels.")
    return float(np.mean(np.isfinite(values) & (values > 0)))


# Quality of the expected error, given the true errors: the share within it, and its ranking of pixels.

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
