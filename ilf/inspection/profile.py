"""Depth along a line between two points of the image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from ..errors import InputError
from ..io.tables import csv_text

ImagePoint = tuple[float, float]
"""Image coordinates x, y: the pixel in row r, column c covers x in [c, c + 1), y in [r, r + 1)."""


@dataclass(frozen=True, eq=False)
class DepthProfile:
    """Samples of depth along a line, one per pixel that it passes.

    Attributes
    ----------
    columns, rows : ndarray of intp, shape (N,)
        The pixels, from the line's start to its end.
    pixels : ndarray of float64, shape (N,)
        Distance from the first of them in the image [px].
    metres : ndarray of float64, shape (N,), or None
        Distance along the surface [m]: from each sample with depth straight to the next one in space. It is
        interpolated where depth is missing, NaN before the first and after the last sample with depth, and None without
        intrinsics.
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
        """A table with a line per sample; the cell of what is missing is empty."""
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
    intrinsics: CameraIntrinsics | None = None,
    others: Mapping[str, ArrayLike] | None = None,
) -> DepthProfile:
    """Depth along the straight line between two points, at the pixels that it passes: nothing is interpolated.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). What is not finite and positive is missing.
    start, end : (float, float)
        Image coordinates x, y. What lies off the image is left out.
    intrinsics : CameraIntrinsics, optional
        Needed for distances along the surface.
    others : mapping of str to array_like, optional
        Other maps (H, W) by name, to be read at the same pixels as they are.

    Raises
    ------
    InputError
        If shapes differ or no part of the line lies on the image.

    Examples
    --------
    >>> depth = np.array([[2.0, np.nan, 2.0, 2.0]])
    >>> profile = depth_profile(depth, (0.5, 0.5), (3.5, 0.5), CameraIntrinsics(100.0, 100.0, 0.0, 0.0))
    >>> profile.depth.tolist(), profile.pixels.tolist()
    ([2.0, nan, 2.0, 2.0], [0.0, 1.0, 2.0, 3.0])
    >>> profile.metres.round(3).tolist()
    [0.0, 0.02, 0.04, 0.06]
    """
    image = np.asarray(depth, np.float32)
    if image.ndim != 2:
        raise InputError(f"A profile needs depth of shape (H, W), not {image.shape}.")
    columns, rows = _pixels(start, end)
    height, width = image.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    if not inside.any():
        raise InputError("No part of the line lies on the image. Draw it across the frame.")
    columns, rows = columns[inside], rows[inside]
    found = image[rows, columns]
    found = np.where(np.isfinite(found) & (found > 0), found, np.float32(np.nan))
    pixels = np.hypot(columns - columns[0], rows - rows[0])
    metres = None if intrinsics is None else _along(intrinsics.points(columns, rows, found), pixels)
    return DepthProfile(columns, rows, pixels, metres, found, _others(others or {}, image.shape, rows, columns))


def _pixels(start: ImagePoint, end: ImagePoint) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Columns and rows of the pixels between two, one per step along the longer side."""
    if not np.isfinite([*start, *end]).all():
        raise InputError(f"The ends of a line must be finite image coordinates, not {start} and {end}.")
    (x0, y0), (x1, y1) = np.floor(start), np.floor(end)
    steps = int(max(abs(x1 - x0), abs(y1 - y0)))
    return (
        np.rint(np.linspace(x0, x1, steps + 1)).astype(np.intp),
        np.rint(np.linspace(y0, y1, steps + 1)).astype(np.intp),
    )


def _along(points: NDArray[np.float64], pixels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length of the way through points (N, 3) up to each of them; pixels say where missing ones lie between."""
    known = np.isfinite(points[:, 2])
    if not known.any():
        return np.full(len(points), np.nan)
    steps = np.linalg.norm(np.diff(points[known], axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(pixels, pixels[known], lengths, left=np.nan, right=np.nan)


def _others(
    maps: Mapping[str, ArrayLike], shape: tuple[int, ...], rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> dict[str, NDArray[np.float32]]:
    arrays = {name: np.asarray(values) for name, values in maps.items()}
    for name, array in arrays.items():
        if array.shape != shape:
            raise InputError(f"The map {name!r} of shape {array.shape} does not belong to depth of shape {shape}.")
    return {name: array[rows, columns].astype(np.float32) for name, array in arrays.items()}
