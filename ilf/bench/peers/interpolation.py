"""Interpolation between known pixels by their positions alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import LinearNDInterpolator
from scipy.ndimage import binary_erosion, distance_transform_edt

from ...frame import RGBDFrame


def nearest(frame: RGBDFrame) -> NDArray[np.float32]:
    """Depth of the nearest known pixel."""
    places = distance_transform_edt(~frame.known, return_distances=False, return_indices=True)
    return frame.depth[tuple(places)]


def linear(frame: RGBDFrame) -> NDArray[np.float32]:
    """Linear interpolation over the Delaunay triangles of the known pixels; the nearest outside their hull."""
    # A triangle over missing pixels has its corners at the rims of holes only: the circle around it is empty, and
    # one through a pixel whose eight neighbours are all known is not.
    known = frame.known
    corners = np.argwhere(known & ~binary_erosion(known, np.ones((3, 3), bool), border_value=1)).astype(np.float64)
    filled = nearest(frame)
    spread = corners - corners.mean(axis=0) if corners.size else corners
    if np.linalg.matrix_rank(spread) < 2:
        return filled
    missing = ~known
    places = tuple(corners.astype(np.intp).T)
    between = LinearNDInterpolator(corners, frame.depth[places])(np.argwhere(missing))
    filled[missing] = np.where(np.isnan(between), filled[missing], between)
    return filled
