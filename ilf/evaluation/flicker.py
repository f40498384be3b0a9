"""Flicker: how much the depth of a point changes from one frame of a sequence to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..data.camera import Camera

_NEAREST_M = 0.05
"""Points nearer to the camera than this are not projected [m]."""


def moved(
    depth: NDArray[np.float32], camera: Camera, motion: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.floating]]:
    """Find the points of a depth image in the image of the same camera at another place.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    camera : Camera
    motion : ndarray of float64, shape (4, 4)
        Transform of points [m] from this camera to that at the other place.

    Returns
    -------
    index : ndarray of intp, shape (H, W)
        Flat index of the pixel of the other image that shows the same point; -1 for none.
    there : ndarray, shape (H, W)
        Depth of the point there [m].
    """
    rows, columns = np.indices(depth.shape)
    points = camera.points(columns, rows, depth) @ motion[:3, :3].T + motion[:3, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        x = np.rint(camera.fx * points[..., 0] / points[..., 2] + camera.cx)
        y = np.rint(camera.fy * points[..., 1] / points[..., 2] + camera.cy)
        inside = (x >= 0) & (y >= 0) & (x < depth.shape[1]) & (y < depth.shape[0]) & (points[..., 2] > _NEAREST_M)
    index = np.where(inside, np.nan_to_num(y) * depth.shape[1] + np.nan_to_num(x), -1).astype(np.intp)
    return index, points[..., 2]


def flicker(
    depth: NDArray[np.float32],
    other: NDArray[np.float32],
    camera: Camera | None = None,
    motion: NDArray[np.float64] | None = None,
) -> NDArray[np.float32]:
    """Return the change of the depth of every point against another frame of the sequence, such as the one before.

    Where the camera has moved, a point that something hides in the other frame differs by the distance of the two.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    other : ndarray of float32, shape (H, W)
        Depth of the other frame [m], NaN = missing.
    camera : Camera, optional
        Needed with `motion`.
    motion : ndarray of float64, shape (4, 4), optional
        Transform of points [m] from this frame's camera to the other one's; None: the camera stands still.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth less the other frame's depth of the same point [m]; NaN where one of them is missing, or where the other
        frame does not show the point.

    Examples
    --------
    >>> flicker(np.float32([[2.0, np.nan]]), np.float32([[1.5, 1.0]]))
    array([[0.5, nan]], dtype=float32)
    """
    if camera is None or motion is None:
        return depth - other
    index, there = moved(depth, camera, motion)
    change = np.where(index >= 0, there - other.ravel()[np.maximum(index, 0)], np.nan)
    return change.astype(np.float32)
