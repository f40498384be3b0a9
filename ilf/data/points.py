"""Coloured point clouds from depth and intrinsics."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.arrays import plain_array, without_mask
from ..errors import InputError, ParameterError
from .camera import REMEDY, Camera, as_camera
from .open3d_images import load_open3d

AXES = ("camera", "y-up")
"""camera: x right, y down, z forward. y-up: x right, y up, z towards the viewer."""

LENGTHS = ("expected_error",)
"""Scalars that are lengths [m], written in the unit of the points."""

NEAREST, FARTHEST = 1e-6, 1e6
"""Depth range [m] outside which a pixel gives no point, so that all values derived from depth are finite."""

_AT_ONCE = 1 << 18  # points, so that intermediate arrays in double precision stay small


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Coloured points with optional normals and scalars.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3) [m], all finite.
    colours : ndarray
        uint8 (N, 3), RGB.
    normals : ndarray, optional
        float32 (N, 3), of length 1.
    scalars : mapping, optional
        Name -> ndarray (N,): "expected_error" float32 [m], 0 where depth was measured; "filled", "from_neighbours" and
        "unsupported" bool;
        "block" int32, 0 = none. Others under any name of letters, digits and underscores; all are written as float32.
    image_shape : (int, int), optional
        Rows and columns of the image if each of its pixels has a point: an organised cloud, row by row.

    Raises
    ------
    InputError
        If shapes do not fit, a name is invalid, or a number is not finite.
    """

    points: NDArray[np.float32]
    colours: NDArray[np.uint8]
    normals: NDArray[np.float32] | None = None
    scalars: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    image_shape: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or self.points.shape != self.colours.shape:
            given = f"{self.points.shape} and {self.colours.shape}"
            raise InputError(f"A cloud needs points and colours of one shape (N, 3), not {given}.")
        if self.normals is not None and self.normals.shape != self.points.shape:
            raise InputError(f"The cloud's normals must have shape {self.points.shape}, not {self.normals.shape}.")
        if self.image_shape is not None and self.image_shape[0] * self.image_shape[1] != len(self.points):
            raise InputError(f"An image of shape {self.image_shape} does not have {len(self.points)} pixels.")
        for name, values in self.scalars.items():
            if not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
                raise InputError(f"The name of a scalar must be letters, digits and underscores, not {name!r:.60}.")
            if values.shape != (len(self.points),):
                raise InputError(f"The scalar {name} must have shape ({len(self.points)},), not {values.shape}.")
        for what, numbers in {"points": self.points, "normals": self.normals, **self.scalars}.items():
            if numbers is not None and not _all_finite(numbers):
                raise InputError(f"The {what} of a cloud must be finite and not masked: remove points that are not.")

    def __len__(self) -> int:
        return len(self.points)

    def to_open3d(self) -> Any:
        """Return points, colours and normals as an `open3d.geometry.PointCloud`, which has no scalars.

        Raises
        ------
        ExportError
            If Open3D is not installed (extra `app`).
        """
        o3d = load_open3d()
        points, colours, normals = (
            None if values is None else o3d.utility.Vector3dVector(values.astype(np.float64))
            for values in (self.points, self.colours / 255, self.normals)
        )
        cloud = o3d.geometry.PointCloud(points)
        cloud.colors = colours
        if normals is not None:
            cloud.normals = normals
        return cloud


def _all_finite(numbers: NDArray[Any]) -> bool:
    """Whether no number is masked, NaN or infinite."""
    if np.ma.is_masked(numbers):
        return False
    return numbers.dtype.kind != "f" or all(
        np.isfinite(numbers[start : start + _AT_ONCE]).all() for start in range(0, len(numbers), _AT_ONCE)
    )


def point_cloud(
    depth: ArrayLike,
    rgb: ArrayLike,
    intrinsics: Camera | ArrayLike | None,
    *,
    only: NDArray[np.bool_] | None = None,
    normals: NDArray[np.float32] | None = None,
    scalars: Mapping[str, NDArray[Any]] | None = None,
) -> PointCloud:
    """Back-project every known pixel through the pinhole camera.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). Values that are not finite and positive are missing and
        give no point; nor do values outside `NEAREST` to `FARTHEST`.
    rgb : array_like
        uint8 (H, W, 3).
    intrinsics : Camera or array_like
        Of this image: also fx, fy, cx, cy, or a 3 x 3 matrix.
    only : ndarray, optional
        bool (H, W): pixels that may give points.
    normals : ndarray, optional
        float32 (H, W, 3), from `surface_normals`.
    scalars : mapping, optional
        Name -> ndarray (H, W) of further values of every pixel; see `PointCloud`. NaN in lengths, such as the expected
        error where depth was measured, becomes 0.

    Returns
    -------
    PointCloud
        In camera axes, row by row; organised if every pixel gives a point.

    Raises
    ------
    InputError
        Without intrinsics, or if the shapes do not fit.

    Examples
    --------
    >>> depth, rgb = np.array([[2.0, np.nan]]), np.zeros((1, 2, 3), np.uint8)
    >>> point_cloud(depth, rgb, Camera(100.0, 100.0, 50.0, 0.0)).points.tolist()
    [[-1.0, 0.0, 2.0]]
    """
    z_image, colour = plain_array(depth), without_mask(rgb)
    if z_image.ndim != 2 or colour.shape != (*z_image.shape, 3) or colour.dtype != np.uint8:
        given = f"{z_image.shape} and {colour.dtype} {colour.shape}"
        raise InputError(f"A point cloud needs depth (H, W) and uint8 colour (H, W, 3), not {given}.")
    images = {name: plain_array(image) for name, image in (scalars or {}).items()}
    if normals is not None and normals.shape != colour.shape:
        raise InputError(f"The normals must have shape {colour.shape}, not {normals.shape}.")
    for name, image in images.items():
        if image.shape != z_image.shape:
            raise InputError(f"The scalar {name} must have shape {z_image.shape}, not {image.shape}.")
    points, pixels = back_project(z_image, intrinsics, only)
    of_points = {name: image.reshape(-1)[pixels] for name, image in images.items()}
    for name in of_points.keys() & set(LENGTHS):
        np.nan_to_num(of_points[name], copy=False, nan=0.0)
    return PointCloud(
        points,
        colour.reshape(-1, 3)[pixels],
        None if normals is None else normals.reshape(-1, 3)[pixels],
        of_points,
        z_image.shape if len(points) == z_image.size else None,
    )


def back_project(
    depth: ArrayLike, intrinsics: Camera | ArrayLike | None, only: NDArray[np.bool_] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return the points of the known pixels, and the indices of these pixels.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). Values that are not finite and positive are missing and
        give no point; nor do values outside `NEAREST` to `FARTHEST`.
    intrinsics : Camera
        Of this image.
    only : ndarray, optional
        bool (H, W): pixels that may give points.

    Returns
    -------
    points : ndarray
        float32 (N, 3) [m] in camera axes, row by row.
    pixels : ndarray
        int32 (N,), ascending: index of each point's pixel, row times W plus column.

    Raises
    ------
    InputError
        Without intrinsics.

    Examples
    --------
    >>> points, pixels = back_project([[2.0, np.nan], [1.0, 4.0]], Camera(100.0, 100.0, 1.0, 0.0))
    >>> points[:, 2].tolist(), pixels.tolist()
    ([2.0, 1.0, 4.0], [0, 2, 3])
    """
    image = plain_array(depth)
    camera = required_intrinsics(intrinsics, image.shape)
    known = known_pixels(image)
    if only is not None:
        known &= plain_array(only)
    pixels = np.flatnonzero(known).astype(np.int32)
    points = np.empty((len(pixels), 3), np.float32)
    for start in range(0, len(pixels), _AT_ONCE):
        some = pixels[start : start + _AT_ONCE]
        rows, columns = np.divmod(some, np.int32(image.shape[1]))
        points[start : start + _AT_ONCE] = camera.points(columns, rows, image.reshape(-1)[some])
    return points, pixels


def known_pixels(depth: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Return the pixels whose depth gives a point, bool (H, W)."""
    with np.errstate(invalid="ignore"):
        known = depth > NEAREST
        known &= depth < FARTHEST
    return np.asarray(known)


def required_intrinsics(intrinsics: Camera | ArrayLike | None, shape: tuple[int, int]) -> Camera:
    """Return the intrinsics of an image (H, W), which points and normals require; raise InputError if there are
    none."""
    if intrinsics is None:
        raise InputError(f"Points and normals need the camera's intrinsics, and this frame has none. {REMEDY}")
    return as_camera(intrinsics, shape)


def in_world(cloud: PointCloud, pose: NDArray[np.float64]) -> PointCloud:
    """Transform a cloud from camera axes to world coordinates by the camera's pose.

    Parameters
    ----------
    cloud : PointCloud
    pose : ndarray of float64, shape (4, 4)
        See `RGBDFrame.pose`.

    Examples
    --------
    >>> cloud = PointCloud(np.array([[1, 2, 3]], np.float32), np.zeros((1, 3), np.uint8))
    >>> pose = np.eye(4)
    >>> pose[0, 3] = 10
    >>> in_world(cloud, pose).points.tolist()
    [[11.0, 2.0, 3.0]]
    """
    turn, shift = pose[:3, :3].astype(np.float32), pose[:3, 3].astype(np.float32)
    normals = None if cloud.normals is None else cloud.normals @ turn.T
    return replace(cloud, points=cloud.points @ turn.T + shift, normals=normals)


def axes_signs(axes: str) -> tuple[int, int, int]:
    """Return the factors of x, y and z from camera axes to one of `AXES`; raise ParameterError for others."""
    if axes not in AXES:
        raise ParameterError(f"axes must be one of {', '.join(AXES)}, not {axes!r}.")
    return (1, 1, 1) if axes == "camera" else (1, -1, -1)
