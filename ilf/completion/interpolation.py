"""Interpolation between known pixels by position only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion
from scipy.spatial import Delaunay

from ..data.frame import RGBDFrame
from ..data.pixel_grids import filled_from_nearest


def nearest(frame: RGBDFrame) -> NDArray[np.float32]:
    """Depth of the nearest known pixel."""
    return filled_from_nearest(frame.depth)


def linear(frame: RGBDFrame) -> NDArray[np.float32]:
    """Linear interpolation over the Delaunay triangles of the known pixels; the nearest outside their hull."""
    # Triangles over missing pixels have their corners on the rims of holes only: their circumcircles contain no known
    # pixel, and a circle through a pixel with eight known neighbours does.
    known = frame.known
    corners = np.argwhere(known & ~binary_erosion(known, np.ones((3, 3), bool), border_value=1))
    filled = nearest(frame)
    # fewer than three points, or collinear ones, have no triangle
    if len(corners) < 3 or np.linalg.matrix_rank(np.diff(corners, axis=0)) < 2:
        return filled
    triangles = Delaunay(corners).simplices
    rows, columns, between = _inside(corners[triangles], frame.depth[tuple(corners.T)].astype(np.float64)[triangles])
    missing = ~known[rows, columns]
    filled[rows[missing], columns[missing]] = between[missing]
    return filled


def _inside(
    corners: NDArray[np.int64], values: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Rows and columns of the pixels in triangles, rims included, and the linear interpolation there.

    SciPy's interpolator finds the triangle of each point with tiny LAPACK calls, whose threads need minutes for a frame
    on a busy machine. On the pixel grid, integer arithmetic is enough, and exact.

    Parameters
    ----------
    corners : ndarray of int, shape (T, 3, 2)
        Rows and columns of the corners.
    values : ndarray of float, shape (T, 3)
        Values at the corners.
    """
    # On side i, slope * column + rise * row + constant is 0. Inside, all three are positive; each, divided by twice the
    # area, is the weight of the opposite corner.
    along = np.roll(corners, -1, axis=1) - corners
    twice_area = along[:, 0, 1] * along[:, 1, 0] - along[:, 0, 0] * along[:, 1, 1]
    turn = np.sign(twice_area)[:, None]
    slope, rise = -turn * along[..., 0], turn * along[..., 1]
    constant = -slope * corners[..., 1] - rise * corners[..., 0]
    weighted = np.roll(values, 1, axis=1) / np.maximum(np.abs(twice_area), 1)[:, None]

    first, last = corners[..., 0].min(axis=1), corners[..., 0].max(axis=1)
    triangle, row = _ranges(first, np.where(twice_area == 0, first - 1, last))
    offset, slope = rise[triangle] * row[:, None] + constant[triangle], slope[triangle]
    left = np.where(slope > 0, -(offset // np.maximum(slope, 1)), np.iinfo(np.int64).min).max(axis=1)
    right = np.where(slope < 0, offset // np.maximum(-slope, 1), np.iinfo(np.int64).max).min(axis=1)
    line, column = _ranges(left, right)
    weights = slope[line] * column[:, None] + offset[line]
    return row[line], column, (weights * weighted[triangle[line]]).sum(axis=1)


def _ranges(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For each pair, all integers from `first` to `last`; returned after the index of the pair that each belongs to."""
    counts = np.maximum(last - first + 1, 0)
    pair = np.repeat(np.arange(counts.size), counts)
    return pair, np.arange(pair.size) - np.repeat(np.cumsum(counts) - counts - first, counts)
