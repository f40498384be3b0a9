"""Which way the surface faces at every pixel, from the slope of its inverse depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from .links import Links, surface_links
from .points import known_pixels

_RADIUS, _ROUNDS = 4, 2
"""Slopes are averaged so often with those of linked pixels so far away, against the noise of sensors."""

_BAND = 256  # rows at a time, so that intermediate arrays stay small

Array = NDArray[np.float32]
Double = NDArray[np.float64]


def surface_normals(depth: ArrayLike, intrinsics: CameraIntrinsics) -> Array:
    """Which way the surface faces at every pixel.

    The inverse depth of a plane is linear across the image, so its slope gives the normal. It is averaged over linked
    neighbours, a few pixels around (sigma 3.7 px), but never across a jump.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). What is not finite and positive is missing.
    intrinsics : CameraIntrinsics
        Of this image.

    Returns
    -------
    ndarray of float32, shape (H, W, 3)
        Unit vectors in camera axes, towards the camera; 0, 0, -1 where a pixel is linked to none or depth is missing.

    Examples
    --------
    >>> normals = surface_normals(np.full((3, 4), 2.0), CameraIntrinsics(100.0, 100.0, 1.5, 1.0))
    >>> bool(np.allclose(normals, (0, 0, -1)))
    True
    """
    image = np.asarray(depth, np.float32)
    links = surface_links(image, intrinsics)
    height = len(image)
    found = np.empty((*image.shape, 3), np.float32)
    for top in range(0, height, _BAND):
        bottom = min(top + _BAND, height)
        first, last = max(top - _ROUNDS * _RADIUS - 1, 0), min(bottom + _ROUNDS * _RADIUS + 1, height)
        around = Links(links.right[first:last], links.down[first : last - 1])
        normals = _normals(image[first:last], around, intrinsics, first)
        found[top:bottom] = normals[top - first : bottom - first]
    return found


def _normals(depth: Array, links: Links, intrinsics: CameraIntrinsics, first_row: int) -> Array:
    known = known_pixels(depth)
    inverse = np.divide(1, depth, out=np.zeros(depth.shape, np.float32), where=known)
    across, along = _slopes(inverse, links), _slopes(inverse.T, Links(links.down.T, links.right.T)).T
    rows, columns = np.arange(depth.shape[0], dtype=np.float32)[:, None], np.arange(depth.shape[1], dtype=np.float32)
    sight_x = (columns - np.float32(intrinsics.cx)) / np.float32(intrinsics.fx)
    sight_y = (rows + np.float32(first_row - intrinsics.cy)) / np.float32(intrinsics.fy)
    # a plane n . P = 1 has the inverse depth n_x x / z + n_y y / z + n_z
    normal = np.empty((*depth.shape, 3), np.float32)
    np.multiply(across, np.float32(-intrinsics.fx), out=normal[..., 0])
    np.multiply(along, np.float32(-intrinsics.fy), out=normal[..., 1])
    normal[..., 2] = -inverse - normal[..., 0] * sight_x - normal[..., 1] * sight_y
    normal[~known] = (0, 0, -1)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return normal


def _slopes(inverse: Array, links: Links) -> Array:
    """Mean step along the rows, in the middle of linked pixels; 0 where there is none."""
    total, count = np.zeros(inverse.shape), np.zeros(inverse.shape)
    step = np.where(links.right, np.diff(inverse, axis=1), 0)
    for side in (np.s_[:, :-1], np.s_[:, 1:]):
        total[side] += step
        count[side] += links.right
    along, across = _reach(links.right), _reach(links.down.T)
    for _ in range(_ROUNDS):
        total, count = (_box_sums(_box_sums(values, *along).T, *across).T for values in (total, count))
    return np.divide(total, count, out=np.zeros(inverse.shape), where=count > 0).astype(np.float32)


def _reach(linked: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First pixel of each pixel's row that it is averaged with, and the one after the last: near by, and linked."""
    height, width = linked.shape[0], linked.shape[1] + 1
    here = np.arange(width)
    first, last = np.zeros((height, width), np.intp), np.full((height, width), width - 1)
    first[:, 1:] = np.where(linked, 0, here[1:])
    last[:, :-1] = np.where(linked, width - 1, here[:-1])
    np.maximum.accumulate(first, axis=1, out=first)
    np.minimum.accumulate(last[:, ::-1], axis=1, out=last[:, ::-1])
    return np.maximum(first, here - _RADIUS), np.minimum(last, here + _RADIUS) + 1


def _box_sums(values: Double, first: NDArray[np.intp], end: NDArray[np.intp]) -> Double:
    """Sum of the values of each row from `first` to before `end`."""
    sums = np.zeros((len(values), values.shape[1] + 1))
    np.cumsum(values, axis=1, out=sums[:, 1:])
    return np.asarray(np.take_along_axis(sums, end, 1) - np.take_along_axis(sums, first, 1))
