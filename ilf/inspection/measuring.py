"""Distances, heights and angles between points of the image that have depth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from ..errors import InputError
from ..io.tables import csv_text
from .profile import ImagePoint
from .surfaces import PlaneFit

CAMERA_UP = (0.0, -1.0, 0.0)
"""Up in the image: the camera's y points down."""

NEEDS_CAMERA = "Lengths and angles in space need the camera's intrinsics, and this frame has none. Open it with them."


@dataclass(frozen=True, eq=False)
class Measured:
    """A chain of points in space.

    Attributes
    ----------
    points : ndarray of float64, shape (N, 3)
        In camera axes [m]: x right, y down, z forward; NaN where there is no depth.
    distances : ndarray of float64, shape (N - 1,)
        From each point straight to the next [m].
    heights : ndarray of float64, shape (N - 1,)
        How much higher the next point lies [m].
    angles : ndarray of float64, shape (N,)
        Between the ways to the points before and after [degrees]; NaN at the ends of the chain.
    """

    points: NDArray[np.float64]
    distances: NDArray[np.float64]
    heights: NDArray[np.float64]
    angles: NDArray[np.float64]

    @property
    def length(self) -> float:
        """Of the whole chain [m]; NaN if a point has no depth."""
        return float(self.distances.sum())


def place_of(
    depth: NDArray[np.floating], point: ImagePoint, intrinsics: CameraIntrinsics | None
) -> NDArray[np.float64]:
    """Where the pixel at image coordinates x, y lies in space [m]: the centre of the pixel, at its depth.

    Raises
    ------
    InputError
        Without intrinsics, off the image, or where depth is missing.

    Examples
    --------
    >>> place_of(np.full((9, 9), 2.0), (5.9, 4.1), CameraIntrinsics(100.0, 100.0, 0.0, 4.0)).tolist()
    [0.1, 0.0, 2.0]
    """
    if intrinsics is None:
        raise InputError(NEEDS_CAMERA)
    column, row = math.floor(point[0]), math.floor(point[1])
    height, width = depth.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InputError(f"The point x {column}, y {row} lies off the image. Choose one on it.")
    z = float(depth[row, column])
    if not (math.isfinite(z) and z > 0):
        raise InputError(f"There is no depth at x {column}, y {row}. Choose a pixel beside it, or complete the block.")
    return intrinsics.points(column, row, z)


def measure(
    depth: ArrayLike,
    chain: Sequence[ImagePoint],
    intrinsics: CameraIntrinsics | None,
    up: tuple[float, float, float] = CAMERA_UP,
) -> Measured:
    """Distances, heights and angles along a chain of points of the image.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). What is not finite and positive is missing.
    chain : sequence of (float, float)
        Image coordinates x, y.
    intrinsics : CameraIntrinsics
    up : (float, float, float)
        Where heights are measured along, in camera axes: the image's upright unless given, or a `PlaneFit.normal`.

    Returns
    -------
    Measured
        With NaN for what depends on a point without depth, which may have lost it since it was chosen.

    Raises
    ------
    InputError
        Without intrinsics, or if `up` has no direction.

    Examples
    --------
    >>> camera = CameraIntrinsics(100.0, 100.0, 0.0, 0.0)
    >>> found = measure(np.full((9, 9), 2.0), [(0.5, 3.5), (0.5, 0.5), (4.5, 0.5)], camera)
    >>> found.distances.round(3).tolist(), found.heights.round(3).tolist()
    ([0.06, 0.08], [0.06, 0.0])
    >>> found.angles.round(1).tolist()
    [nan, 90.0, nan]
    """
    if intrinsics is None:
        raise InputError(NEEDS_CAMERA)
    axis = np.asarray(up, np.float64)
    size = float(np.linalg.norm(axis))
    if not (math.isfinite(size) and size > 0):
        raise InputError(f"Heights are measured along a direction, which {up} is not.")
    image = np.asarray(depth)
    points = np.array([_place_or_nan(image, point, intrinsics) for point in chain]).reshape(-1, 3)
    ways = np.diff(points, axis=0)
    angles = np.full(len(points), np.nan)
    for n in range(1, len(points) - 1):
        angles[n] = _angle(-ways[n - 1], ways[n])
    return Measured(points, np.linalg.norm(ways, axis=1), ways @ axis / size + 0.0, angles)


def angle_between(one: PlaneFit, other: PlaneFit) -> float:
    """Angle between two planes [degrees], 0 for parallel ones, at most 90.

    Raises
    ------
    InputError
        If one of them was fitted without intrinsics.

    Examples
    --------
    >>> floor, wall = PlaneFit(0.0, 0.0, (0.0, -1.0, 0.0), 90.0), PlaneFit(0.0, 0.0, (0.0, 0.0, -1.0), 0.0)
    >>> angle_between(floor, wall)
    90.0
    """
    if one.normal is None or other.normal is None:
        raise InputError(NEEDS_CAMERA)
    angle = _angle(np.array(one.normal), np.array(other.normal))
    return min(angle, 180.0 - angle)


def measurements_csv(chains: Iterable[tuple[Sequence[ImagePoint], Measured]]) -> str:
    """A table with a line per point: where it is, how far from the one before and how much higher, and the angle there.

    What is missing is an empty cell.
    """
    names = ["x_m", "y_m", "z_m", "distance_m", "height_m", "angle_deg"]
    rows: list[list[object]] = [["measurement", "point", "x", "y", *names]]
    for number, (chain, measured) in enumerate(chains, 1):
        for n, (x, y) in enumerate(chain):
            since = [measured.distances[n - 1], measured.heights[n - 1]] if n else [math.nan, math.nan]
            values = [*measured.points[n], *since, measured.angles[n]]
            cells = ["" if math.isnan(value) else f"{value:.5f}" for value in values]
            rows.append([number, n + 1, math.floor(x), math.floor(y), *cells])
    return csv_text(rows)


def _place_or_nan(depth: NDArray[np.floating], point: ImagePoint, intrinsics: CameraIntrinsics) -> NDArray[np.float64]:
    try:
        return place_of(depth, point, intrinsics)
    except InputError:
        return np.full(3, np.nan)


def _angle(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Between two directions [degrees]; NaN if one of them has none."""
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    if not size > 0:
        return math.nan
    # well conditioned for small angles, too
    return math.degrees(math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other)))
