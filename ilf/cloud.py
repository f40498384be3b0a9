"""Depth and intrinsics -> coloured point cloud."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError, ParameterError
from .frame import CameraIntrinsics

AXES = ("camera", "y-up")
"""camera: x right, y down, z forward. y-up: x right, y up, z towards the viewer."""


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Coloured points.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m].
    colours : ndarray
        uint8 (N, 3), red first.
    """

    points: NDArray[np.float32]
    colours: NDArray[np.uint8]

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or self.points.shape != self.colours.shape:
            raise InputError(
                f"A cloud needs points and colours of one shape (N, 3), not {self.points.shape} "
                f"and {self.colours.shape}."
            )

    def __len__(self) -> int:
        return len(self.points)


def point_cloud(depth: ArrayLike, rgb: ArrayLike, intrinsics: CameraIntrinsics | None) -> PointCloud:
    """Back-project every known pixel through the pinhole camera.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). What is not finite and positive is missing and
        gives no point.
    rgb : array_like
        uint8 (H, W, 3).
    intrinsics : CameraIntrinsics
        Of this image.

    Returns
    -------
    PointCloud
        In camera axes, row by row.

    Raises
    ------
    InputError
        Without intrinsics, or if the shapes do not fit.

    Examples
    --------
    >>> depth, rgb = np.array([[2.0, np.nan]]), np.zeros((1, 2, 3), np.uint8)
    >>> point_cloud(depth, rgb, CameraIntrinsics(100.0, 100.0, 50.0, 0.0)).points.tolist()
    [[-1.0, 0.0, 2.0]]
    """
    z_image, colour = np.asarray(depth), np.asarray(rgb)
    if z_image.ndim != 2 or colour.shape != (*z_image.shape, 3) or colour.dtype != np.uint8:
        raise InputError(
            f"A point cloud needs depth (H, W) and uint8 colour (H, W, 3), not {z_image.shape} and "
            f"{colour.dtype} {colour.shape}."
        )
    points, pixels = back_project(z_image, intrinsics)
    return PointCloud(points, colour.reshape(-1, 3)[pixels])


def back_project(
    depth: ArrayLike, intrinsics: CameraIntrinsics | None, only: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Points of the known pixels, and which pixels they are.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). What is not finite and positive is missing and
        gives no point.
    intrinsics : CameraIntrinsics
        Of this image.
    only : ndarray, optional
        bool (H, W): pixels that may give points.

    Returns
    -------
    points : ndarray
        float32 (N, 3) [m] in camera axes, row by row.
    pixels : ndarray
        int32 (N,), rising: index of each point's pixel, its row times W plus its column.

    Raises
    ------
    InputError
        Without intrinsics.

    Examples
    --------
    >>> points, pixels = back_project([[2.0, np.nan], [1.0, 4.0]], CameraIntrinsics(100.0, 100.0, 1.0, 0.0))
    >>> points[:, 2].tolist(), pixels.tolist()
    ([2.0, 1.0, 4.0], [0, 2, 3])
    """
    if intrinsics is None:
        raise InputError(
            "A point cloud needs the camera's intrinsics, and this frame has none. Give them as a preset "
            "(such as nyu-kinect-v1), as fx,fy,cx,cy, or as a JSON file."
        )
    image = np.asarray(depth)
    known = np.isfinite(image)
    known &= image > 0
    if only is not None:
        known &= only
    pixels = np.flatnonzero(known).astype(np.int32)
    rows, columns = np.divmod(pixels, np.int32(image.shape[1]))
    return intrinsics.points(columns, rows, image.reshape(-1)[pixels]).astype(np.float32), pixels


def in_axes(cloud: PointCloud, axes: str) -> PointCloud:
    """A cloud in camera axes, turned into one of `AXES`.

    Raises
    ------
    ParameterError
        For unknown axes.

    Examples
    --------
    >>> cloud = PointCloud(np.array([[1, 2, 3]], np.float32), np.zeros((1, 3), np.uint8))
    >>> in_axes(cloud, "y-up").points.tolist()
    [[1.0, -2.0, -3.0]]
    """
    if axes not in AXES:
        raise ParameterError(f"axes must be one of {', '.join(AXES)}, not {axes!r}.")
    if axes == "camera":
        return cloud
    return PointCloud(cloud.points * np.array([1, -1, -1], np.float32), cloud.colours)
