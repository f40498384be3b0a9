"""Measuring: depth profiles, and the distance between two image points with depth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..data.arrays import check_shape, plain_array
from ..data.camera import Camera
from ..errors import InputError
from ..io.tables import csv_text
from ..segmentation.editing.patches import values_at
from .statistics import SurfaceFit

# Depth along a line between two points of the image.

ImagePoint = tuple[float, float]
"""Image coordinates x, y: the pixel in row r, column c covers x in [c, c + 1), y in [r, r + 1)."""


@dataclass(frozen=True, eq=False)
class DepthProfile:
    """Samples of depth along a line, one per pixel on it.

    Attributes
    ----------
    columns, rows : ndarray of intp, shape (N,)
        The pixels, from the line's start to its end.
    pixels : ndarray of float64, shape (N,)
        Distance from the first pixel in the image [px].
    metres : ndarray of float64, shape (N,), or None
        Distance along the surface [m]: sum of the straight distances between samples with depth. Interpolated where
        depth is missing, NaN before the first and after the last sample with depth, None without intrinsics.
    depth : ndarray of float32, shape (N,)
        Depth [m], NaN = missing.
    others : dict of str to ndarray of float32, shape (N,)
        Other maps at the same pixels.
    """

    columns: NDArray[np.intp]
    rows: NDArray[np.intp]
    pixels: NDArray[np.float64]
    metres: NDArray[np.float64] | None
    depth: NDArray[np.float32]
    others: dict[str, NDArray[np.float32]]

    def __len__(self) -> int:
        return len(self.pixels)

    def to_csv(self) -> str:
        """A table with one line per sample; missing values are empty cells."""
        metres = {} if self.metres is None else {"surface_m": self.metres}
        lengths = {"distance_px": self.pixels, **metres}
        depths = {"depth_m": self.depth, **self.others}
        rows: list[list[object]] = [["x", "y", *lengths, *depths]]
        for n, (x, y) in enumerate(zip(self.columns.tolist(), self.rows.tolist(), strict=True)):
            cells = [float(f"{values[n]:.6g}") for values in lengths.values()]
            cells += [float(f"{values[n]:.7g}") for values in depths.values()]
            rows.append([x, y, *("" if np.isnan(cell) else cell for cell in cells)])
        return csv_text(rows)


def depth_profile(
    depth: ArrayLike,
    start: ImagePoint,
    end: ImagePoint,
    intrinsics: Camera | None = None,
    others: Mapping[str, ArrayLike] | None = None,
) -> DepthProfile:
    """Sample depth along the straight line between two points, at the pixels on it, without interpolation.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). Values that are not finite and positive are missing.
    start, end : (float, float)
        Image coordinates x, y. Parts outside the image are left out.
    intrinsics : Camera, optional
        Needed for distances along the surface.
    others : mapping of str to array_like, optional
        Other maps (H, W), by name, sampled at the same pixels.

    Raises
    ------
    InputError
        If shapes differ or the line is outside the image.

    Examples
    --------
    >>> depth = np.array([[2.0, np.nan, 2.0, 2.0]])
    >>> profile = depth_profile(depth, (0.5, 0.5), (3.5, 0.5), Camera(100.0, 100.0, 0.0, 0.0))
    >>> profile.depth.tolist(), profile.pixels.tolist()
    ([2.0, nan, 2.0, 2.0], [0.0, 1.0, 2.0, 3.0])
    >>> profile.metres.round(3).tolist()
    [0.0, 0.02, 0.04, 0.06]
    """
    image = np.asarray(plain_array(depth), np.float32)
    if image.ndim != 2:
        raise InputError(f"A profile needs depth of shape (H, W), not {image.shape}.")
    columns, rows = _pixels(start, end)
    height, width = image.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    if not inside.any():
        raise InputError("The line is outside the image. Draw it across the frame.")
    columns, rows = columns[inside], rows[inside]
    found = image[rows, columns]
    found = np.where(np.isfinite(found) & (found > 0), found, np.float32(np.nan))
    pixels = np.hypot(columns - columns[0], rows - rows[0])
    metres = None if intrinsics is None else _path_lengths(intrinsics.points(columns, rows, found), pixels)
    maps = {name: plain_array(values) for name, values in (others or {}).items()}
    for name, array in maps.items():
        check_shape(f"The map {name!r}", array.shape, image.shape, "the depth")
    sampled = {name: array[rows, columns].astype(np.float32) for name, array in maps.items()}
    return DepthProfile(columns, rows, pixels, metres, found, sampled)


def _pixels(start: ImagePoint, end: ImagePoint) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns and rows of the pixels between two points, one per step along the longer side."""
    if not np.isfinite([*start, *end]).all():
        raise InputError(f"The ends of a line must be finite image coordinates, not {start} and {end}.")
    (x0, y0), (x1, y1) = np.floor(start), np.floor(end)
    steps = int(max(abs(x1 - x0), abs(y1 - y0)))
    columns, rows = (np.rint(np.linspace(*ends, steps + 1)).astype(np.intp) for ends in ((x0, x1), (y0, y1)))
    return columns, rows


def _path_lengths(points: NDArray[np.float64], pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length of the path through points (N, 3) up to each of them; missing ones are interpolated by `pixels`."""
    known = np.isfinite(points[:, 2])
    if not known.any():
        return np.full(len(points), np.nan)
    steps = np.linalg.norm(np.diff(points[known], axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(pixels, pixels[known], lengths, left=np.nan, right=np.nan)


NEEDS_INTRINSICS = "Lengths and angles need the camera's intrinsics, and this frame has none. Open it with intrinsics."


Line = tuple[ImagePoint, ImagePoint]
"""Ends in image coordinates."""


@dataclass(frozen=True, eq=False)
class Measured:
    """Two points in space.

    Attributes
    ----------
    points : ndarray of float64, shape (2, 3)
        Points in camera axes [m]: x right, y down, z forward; NaN without depth.
    distance : float
        Straight distance between them [m]; NaN if one has no depth.
    height : float
        How far the second point is above the first along the image's vertical [m].
    """

    points: NDArray[np.float64]

    @property
    def distance(self) -> float:
        return float(np.linalg.norm(self.points[1] - self.points[0]))

    @property
    def height(self) -> float:
        return float(self.points[0, 1] - self.points[1, 1])


def point_in_space(depth: NDArray[np.floating], point: ImagePoint, intrinsics: Camera | None) -> NDArray[np.float64]:
    """Compute the position in space [m] of the pixel at image coordinates x, y: its centre, at its depth.

    Raises
    ------
    InputError
        Without intrinsics, outside the image, or where depth is missing.

    Examples
    --------
    >>> point_in_space(np.full((9, 9), 2.0), (5.9, 4.1), Camera(100.0, 100.0, 0.0, 4.0)).tolist()
    [0.1, 0.0, 2.0]
    """
    if intrinsics is None:
        raise InputError(NEEDS_INTRINSICS)
    column, row = math.floor(point[0]), math.floor(point[1])
    height, width = depth.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InputError(f"The point x {column}, y {row} is outside the image. Select a point in the image.")
    z = float(depth[row, column])
    if not (math.isfinite(z) and z > 0):
        raise InputError(f"There is no depth at x {column}, y {row}. Select a pixel beside it, or complete the block.")
    return intrinsics.points(column, row, z)


def measure(depth: ArrayLike, line: Line, intrinsics: Camera | None) -> Measured:
    """Compute the positions in space of two image points.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). Values that are not finite and positive are missing.
    line : pair of (float, float)
        Image coordinates x, y.
    intrinsics : Camera

    Raises
    ------
    InputError
        Without intrinsics.

    Examples
    --------
    >>> found = measure(np.full((9, 9), 2.0), ((0.5, 3.5), (4.5, 0.5)), Camera(100.0, 100.0, 0.0, 0.0))
    >>> round(found.distance, 3), round(found.height, 3)
    (0.1, 0.06)
    """
    if intrinsics is None:
        raise InputError(NEEDS_INTRINSICS)
    places = np.array(line, np.float64)
    z = values_at(plain_array(depth), places, beyond=0).astype(np.float64)
    columns, rows = np.floor(places).T
    return Measured(intrinsics.points(columns, rows, np.where(np.isfinite(z) & (z > 0), z, np.nan)))


def angle_between(one: SurfaceFit, other: SurfaceFit) -> float:
    """Compute the angle between two planes [degrees], from 0 for parallel ones to 90.

    Raises
    ------
    InputError
        If one of them was fitted without intrinsics.

    Examples
    --------
    >>> floor, wall = SurfaceFit(0.0, 0.0, (0.0, -1.0, 0.0), 90.0), SurfaceFit(0.0, 0.0, (0.0, 0.0, -1.0), 0.0)
    >>> angle_between(floor, wall)
    90.0
    """
    if one.normal is None or other.normal is None:
        raise InputError(NEEDS_INTRINSICS)
    first, second = np.array(one.normal), np.array(other.normal)
    # well conditioned for small angles as well
    angle = math.degrees(math.atan2(float(np.linalg.norm(np.cross(first, second))), float(first @ second)))
    return min(angle, 180.0 - angle)


def measurements_csv(lines: Sequence[Line], found: Sequence[Measured]) -> str:
    """A table with one line per measurement: both points, their distance and height; missing values are empty cells."""
    ends = [f"{name}{end}" for end in (1, 2) for name in ("x", "y", "x_m", "y_m", "z_m")]
    rows: list[list[object]] = [["measurement", *ends, "distance_m", "height_m"]]
    for number, (line, measured) in enumerate(zip(lines, found, strict=True), 1):
        row: list[object] = [number]
        for (x, y), point in zip(line, measured.points, strict=True):
            row += [math.floor(x), math.floor(y), *map(_cell, point)]
        rows.append([*row, _cell(measured.distance), _cell(measured.height)])
    return csv_text(rows)


def _cell(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.5f}"
