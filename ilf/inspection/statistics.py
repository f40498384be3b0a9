"""Depth of a surface in numbers: what is missing, how it spreads, how flat and how noisy it is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from ..errors import InputError
from ..filter.edge_aware.trend import noise_of
from ..masks import checked_mask
from .surfaces import PlaneFit, QuadricFit, fit_depth_plane, fit_depth_quadric, fit_plane, fit_quadric


@dataclass(frozen=True)
class SurfaceStatistics:
    """Depth at some pixels in numbers, all in metres unless said otherwise; NaN where there is nothing to tell it by.

    Attributes
    ----------
    pixels, known : int
        Pixels that were asked for, and those of them with depth.
    mean, median, deviation, least, largest : float
        Of the known depth; the deviation is the standard deviation.
    noise : float
        Standard deviation of what differs from pixel to pixel, whatever the surface's shape: from the median size of
        the second differences of three neighbours in a row or column, over 0.6745 and the root of 6. Depth that comes
        in steps shows less than it has.
    plane : PlaneFit or None
    quadric : QuadricFit or None
    reason : str
        Why there is no plane or no quadric; "" if there are both.
    """

    pixels: int
    known: int
    mean: float
    median: float
    deviation: float
    least: float
    largest: float
    noise: float
    plane: PlaneFit | None
    quadric: QuadricFit | None
    reason: str

    @property
    def missing_share(self) -> float:
        """Share of the pixels without depth, 0-1."""
        return 1.0 - self.known / self.pixels


def surface_statistics(
    depth: ArrayLike, mask: ArrayLike | None = None, intrinsics: CameraIntrinsics | None = None
) -> SurfaceStatistics:
    """Statistics of the depth at the pixels of a mask, with the plane and the quadric that fit it best.

    With intrinsics, both are fitted in camera space, a plane of the world being one there; else to depth over pixel
    coordinates. A few outliers have no pull on them.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). What is not finite and positive is missing.
    mask : array_like of bool, optional
        The pixels, (H, W), such as a block's; all of them if not given.
    intrinsics : CameraIntrinsics, optional

    Raises
    ------
    InputError
        If the shapes do not fit or the mask is empty.

    Examples
    --------
    >>> rows, columns = np.mgrid[:20, :30]
    >>> depth = 2.0 / (1.0 + 0.002 * columns)  # a slanted wall, in camera space
    >>> depth[5, 5] = np.nan
    >>> found = surface_statistics(depth, intrinsics=CameraIntrinsics(500.0, 500.0, 0.0, 0.0))
    >>> found.pixels, found.known, round(found.mean, 3)
    (600, 599, 1.944)
    >>> round(found.plane.tilt, 3), found.plane.rms < 1e-6
    (45.0, True)
    >>> surface_statistics([[1.0, 2.0]]).reason
    'A plane needs at least 12 pixels with depth; here are 2.'
    """
    image = np.asarray(depth, np.float32)
    if image.ndim != 2:
        raise InputError(f"Statistics need depth of shape (H, W), not {image.shape}.")
    wanted = np.ones(image.shape, bool) if mask is None else checked_mask(mask, image.shape, "a surface")
    count = int(np.count_nonzero(wanted))
    if count == 0:
        raise InputError("There is no pixel to take statistics of. Choose a block or draw a rectangle.")
    inside = wanted & np.isfinite(image) & (image > 0)
    rows, columns = np.nonzero(inside)
    z = image[inside].astype(np.float64)
    if z.size == 0:
        none = math.nan
        return SurfaceStatistics(
            count, 0, none, none, none, none, none, none, None, None, "None of the pixels has depth."
        )
    box = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    plane, quadric, reason = _surfaces(z, rows, columns, intrinsics)
    return SurfaceStatistics(
        count,
        z.size,
        float(z.mean()),
        float(np.median(z)),
        float(z.std()),
        float(z.min()),
        float(z.max()),
        noise_of(image[box], inside[box]),
        plane,
        quadric,
        reason,
    )


def _surfaces(
    z: NDArray[np.float64], rows: NDArray[np.intp], columns: NDArray[np.intp], intrinsics: CameraIntrinsics | None
) -> tuple[PlaneFit | None, QuadricFit | None, str]:
    """Plane, quadric, and why there is not one."""
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    plane: PlaneFit | None = None
    try:
        if intrinsics is None:
            plane = fit_depth_plane(z, pixels)
            return plane, fit_depth_quadric(z, pixels), ""
        points = intrinsics.points(columns, rows, z)
        plane = fit_plane(points, pixels)
        return plane, fit_quadric(points, pixels), ""
    except InputError as error:
        return plane, None, str(error)
