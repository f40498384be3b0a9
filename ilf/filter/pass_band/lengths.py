"""Longest and shortest length of a block, from which the pass band starts (section 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def principal_lengths(mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Extent of a block along the two principal axes of its pixel coordinates.

    Parameters
    ----------
    mask : ndarray of bool, shape (h, w)
        The block's pixels; at least one.

    Returns
    -------
    longest, shortest : float
        Lengths [px]; a single pixel has length 1 both ways.
    """
    coordinates = np.argwhere(mask).astype(np.float64)
    coordinates -= coordinates.mean(axis=0)
    _, axes = np.linalg.eigh(coordinates.T @ coordinates)
    along = coordinates @ axes
    extents = along.max(axis=0) - along.min(axis=0) + 1.0
    return float(extents.max()), float(extents.min())
