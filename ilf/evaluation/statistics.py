"""Statistics of a surface's depth: missing share, spread, flatness and noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..completion.edge_aware.shape import noise_of
from ..data.arrays import plain_array
from ..data.camera import Camera
from ..data.frame import checked_mask
from ..errors import InputError

# Planes and quadrics through known depth, by robust least squares.

Array = NDArray[np.float64]

_PER_COEFFICIENT = 4
"""Minimum number of points per coefficient of a surface."""

_MIN_WIDTH = 0.75, 1.05
"""Minimum standard deviation of the pixels across their strip for a plane and for a quadric [px]: a width of three and
of four pixels."""

_MAX_POINTS = 40_000
"""Maximum number of points for a fit, evenly selected."""

_ROUNDS = 12
_CAUCHY_SCALE = 2.385
"""Robust deviations at which Cauchy's weights are halved."""

_OUTLIER = 3.5
"""Robust deviations above which a point is an outlier."""

_ROUNDING = 1e-6
"""Share of depth below which deviations are due to float32 rounding."""


@dataclass(frozen=True)
class SurfaceFit:
    """The plane, or the quadric as a height over that plane, that most points lie on.

    Attributes
    ----------
    rms : float
        Root mean square of the points' distances from it [m] without outliers: along the plane's normal in camera
        space, along the optical axis without intrinsics.
    outliers : float
        Share of the points farther from it than 3.5 robust deviations, 0-1.
    normal : (float, float, float) or None
        Unit normal vector of a plane, towards the camera; None without intrinsics, and for a quadric.
    tilt : float
        Angle between normal and optical axis [degrees], 0 for a plane that faces the camera; NaN without a normal.
    """

    rms: float
    outliers: float
    normal: tuple[float, float, float] | None = None
    tilt: float = math.nan


def check_support(pixels: Array, coefficients: int, width: float, what: str) -> None:
    """Raise InputError if these pixels (N, 2) do not determine a surface of so many coefficients."""
    least = _PER_COEFFICIENT * coefficients
    if len(pixels) < least:
        raise InputError(f"A {what} needs at least {least} pixels with depth, not {len(pixels)}. Select a larger area.")
    across = np.linalg.eigvalsh(np.cov(pixels.T))[0]
    if across < width**2:
        raise InputError(f"The pixels with depth form too narrow a strip for a {what}. Select a wider area.")


def _plane(points: Array) -> tuple[SurfaceFit, Array, Array]:
    """Fit by total least squares; returns the fit, axes (3, 3) with the normal last, and centre."""
    few = _thinned(points)
    weights = np.ones(len(few))
    floor = _ROUNDING * float(np.abs(few[:, 2]).max())
    for _ in range(_ROUNDS):
        axes, centre = _principal(few, weights)
        offsets = (few - centre) @ axes[2]
        weights = _cauchy(offsets, floor)
    good = np.abs(offsets) <= _OUTLIER * _deviation(offsets, floor)
    axes, centre = _principal(few[good], np.ones(np.count_nonzero(good)))
    offsets = (points - centre) @ axes[2]
    rms, outliers = _evaluated(offsets, floor)
    x, y, z = axes[2].tolist()
    tilt = float(np.degrees(np.arccos(min(abs(z), 1.0))))
    return SurfaceFit(rms, outliers, (x, y, z), tilt), axes, centre


def _principal(points: Array, weights: Array) -> tuple[Array, Array]:
    """Axes of largest, second and smallest spread, the last towards the camera, and the centre."""
    centre = np.average(points, axis=0, weights=weights)
    apart = points - centre
    _, vectors = np.linalg.eigh((apart * weights[:, None]).T @ apart)
    axes = vectors.T[::-1].copy()
    if axes[2] @ centre > 0:
        axes[2] *= -1
    return axes, centre


def _height_fit(heights: Array, places: Array, terms: Callable[[Array], Array], depth: float) -> SurfaceFit:
    """Fit heights (N,) as a polynomial of places (N, 2), rotated and scaled for good conditioning."""
    apart = places - places.mean(axis=0)
    spread, turn = np.linalg.eigh(np.cov(apart.T))
    design = terms(apart @ turn / np.sqrt(spread))
    few, low = _thinned(design), _thinned(heights)
    floor = _ROUNDING * depth
    weights = np.ones(len(few))
    for _ in range(_ROUNDS):
        offsets = low - few @ _solved(few, low, weights)
        weights = _cauchy(offsets, floor)
    good = np.abs(offsets) <= _OUTLIER * _deviation(offsets, floor)
    coefficients = _solved(few[good], low[good], np.ones(np.count_nonzero(good)))
    return SurfaceFit(*_evaluated(heights - design @ coefficients, floor))


def _linear(places: Array) -> Array:
    return np.column_stack([np.ones(len(places)), places])


def _quadratic(places: Array) -> Array:
    x, y = places.T
    return np.column_stack([np.ones(len(places)), x, y, x * x, x * y, y * y])


def _solved(design: Array, values: Array, weights: Array) -> Array:
    weighted = design * weights[:, None]
    return np.asarray(np.linalg.lstsq(weighted.T @ design, weighted.T @ values, rcond=None)[0], np.float64)


def _thinned(rows: Array) -> Array:
    return rows[:: max(-(-len(rows) // _MAX_POINTS), 1)]


def _cauchy(offsets: Array, floor: float) -> Array:
    return 1.0 / (1.0 + (offsets / (_CAUCHY_SCALE * _deviation(offsets, floor))) ** 2)


def _deviation(offsets: Array, floor: float) -> float:
    """Robust standard deviation, at least `floor`."""
    return max(float(np.median(np.abs(offsets))) / 0.6745, floor)


def _evaluated(offsets: Array, floor: float) -> tuple[float, float]:
    """Root mean square without outliers, and the share of outliers."""
    good = np.abs(offsets) <= _OUTLIER * _deviation(offsets, floor)
    return float(np.sqrt(np.mean(offsets[good] ** 2))), 1.0 - float(np.mean(good))


@dataclass(frozen=True)
class SurfaceStatistics:
    """Statistics of the depth at some pixels, in metres unless stated otherwise; NaN if undefined.

    Attributes
    ----------
    pixels, known : int
        Number of selected pixels, and of those with depth.
    mean, median, deviation, least, largest : float
        Mean, median, standard deviation, minimum and maximum of the known depth.
    noise : float
        Standard deviation of the pixel noise, independent of the surface's shape: the median absolute second difference
        of three neighbours in a row or column, over 0.6745 and the root of 6. Too small for quantised depth.
    plane : SurfaceFit or None
    quadric : SurfaceFit or None
    reason : str
        Why there is no plane or no quadric; "" if there are both.
    """

    pixels: int
    known: int
    mean: float = math.nan
    median: float = math.nan
    deviation: float = math.nan
    least: float = math.nan
    largest: float = math.nan
    noise: float = math.nan
    plane: SurfaceFit | None = None
    quadric: SurfaceFit | None = None
    reason: str = ""

    @property
    def missing_share(self) -> float:
        """Share of the pixels without depth, 0-1."""
        return 1.0 - self.known / self.pixels


def surface_statistics(
    depth: ArrayLike, mask: ArrayLike | None = None, intrinsics: Camera | None = None
) -> SurfaceStatistics:
    """Compute statistics of the depth at the pixels of a mask, with the best-fitting plane and quadric.

    With intrinsics, both are fitted in camera space; otherwise to depth over pixel coordinates. The fits are robust
    against outliers.

    Parameters
    ----------
    depth : array_like
        Depth [m], (H, W). Values that are not finite and positive are missing.
    mask : array_like of bool, optional
        The pixels, (H, W), such as a block's; all if left out.
    intrinsics : Camera, optional

    Raises
    ------
    InputError
        If the shapes do not fit or the mask is empty.

    Examples
    --------
    >>> rows, columns = np.mgrid[:20, :30]
    >>> depth = 2.0 / (1.0 + 0.002 * columns)  # a slanted wall, in camera space
    >>> depth[5, 5] = np.nan
    >>> found = surface_statistics(depth, intrinsics=Camera(500.0, 500.0, 0.0, 0.0))
    >>> found.pixels, found.known, round(found.mean, 3)
    (600, 599, 1.944)
    >>> round(found.plane.tilt, 3), found.plane.rms < 1e-6
    (45.0, True)
    >>> surface_statistics([[1.0, 2.0]]).reason
    'A plane needs at least 12 pixels with depth, not 2. Select a larger area.'
    """
    image = np.asarray(plain_array(depth), np.float32)
    if image.ndim != 2:
        raise InputError(f"Statistics need depth of shape (H, W), not {image.shape}.")
    wanted = np.ones(image.shape, bool) if mask is None else checked_mask(mask, image.shape, "a surface")
    count = int(np.count_nonzero(wanted))
    if count == 0:
        raise InputError("No pixels are selected for statistics. Select a block or draw a rectangle.")
    inside = wanted & np.isfinite(image) & (image > 0)
    rows, columns = np.nonzero(inside)
    z = image[inside].astype(np.float64)
    if z.size == 0:
        return SurfaceStatistics(count, 0, reason="None of the pixels has depth.")
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
    z: NDArray[np.float64], rows: NDArray[np.intp], columns: NDArray[np.intp], intrinsics: Camera | None
) -> tuple[SurfaceFit | None, SurfaceFit | None, str]:
    """Plane, quadric, and the reason if one is missing."""
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    plane: SurfaceFit | None = None
    farthest = np.abs(z).max()
    try:
        check_support(pixels, 3, _MIN_WIDTH[0], "plane")
        if intrinsics is None:
            heights, places = z, pixels
            plane = _height_fit(heights, places, _linear, farthest)
        else:
            points = intrinsics.points(columns, rows, z)
            plane, axes, centre = _plane(points)
            local = (points - centre) @ axes.T
            heights, places = local[:, 2], local[:, :2]
        check_support(pixels, 6, _MIN_WIDTH[1], "quadric")
        return plane, _height_fit(heights, places, _quadratic, farthest), ""
    except InputError as error:
        return plane, None, str(error)
