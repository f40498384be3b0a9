"""Iterative-inlier polynomial surface fitting, the peer of the paper's experiments on spheres and cylinders."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

INLIER_DEVIATIONS = 2.5
"""Known pixels farther from the surface than so many standard deviations of the others are outliers."""

MAX_ROUNDS = 50

_NORMAL_MAD = 0.6745
"""Median absolute deviation of a normal distribution, in standard deviations."""


def inlier_polynomial(
    depth: NDArray[np.floating], mask: NDArray[np.bool_], order: int, deviations: float = INLIER_DEVIATIONS
) -> tuple[NDArray[np.float64], int]:
    """Fit a polynomial, drop outliers, and fit again until the inliers stay the same.

    The scale that tells outliers is the median absolute deviation of all known pixels from the surface at hand, so
    outliers may come back once the surface is better. The terms are products of Legendre polynomials of
    positions in [-1, 1], made orthonormal over the known pixels once: whatever part of the block is known, the normal
    equations of every round are well conditioned.

    Parameters
    ----------
    depth : ndarray of float, shape (h, w)
        Depth [m], NaN = missing.
    mask : ndarray of bool, shape (h, w)
        The block's pixels.
    order : int
        Largest total power of row and column.
    deviations : float
        How many standard deviations off an outlier is; infinity keeps every point.

    Returns
    -------
    surface : ndarray of float64, shape (h, w)
        Depth [m] everywhere; NaN if the known pixels do not determine the polynomial.
    rounds : int
        Fits that it took.
    """
    known = mask & np.isfinite(depth)
    terms = _terms(known.shape, order)
    values = depth[known].astype(np.float64)
    basis = terms[known]
    if len(basis) < basis.shape[1] or np.linalg.matrix_rank(basis.T @ basis) < basis.shape[1]:
        return np.full(depth.shape, np.nan), 0
    orthonormal, triangle = np.linalg.qr(basis)
    inliers = np.ones(values.size, bool)
    rounds = 0
    while True:
        rounds += 1
        kept = orthonormal[inliers]
        weights = np.linalg.solve(kept.T @ kept, kept.T @ values[inliers])
        off = np.abs(values - orthonormal @ weights)
        scale = float(np.median(off)) / _NORMAL_MAD
        # what rounding leaves of an exact fit is no outlier
        now = off <= (max(deviations * scale, 1e-9) if scale else 1e-9)
        if rounds == MAX_ROUNDS or np.array_equal(now, inliers):
            break
        inliers = now
    return terms @ np.linalg.solve(triangle, weights), rounds


def _terms(shape: tuple[int, int], order: int) -> NDArray[np.float64]:
    """The terms at every pixel, shape (h, w, number of terms)."""
    y, x = (legendre.legvander((2 * np.arange(size) + 1) / size - 1, order) for size in shape)
    return np.stack([y[:, None, a] * x[None, :, b] for a in range(order + 1) for b in range(order + 1 - a)], axis=-1)
