"""A halogen-like spot: a round hole of 15 cm where the depth is known and smooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from ...errors import InputError

DIAMETER = 0.15
"""[m], at the depth of its middle."""

NOMINAL_FOCAL = 0.82
"""Focal length in widths of the image where a frame has no intrinsics: that of a Kinect, 525 px at 640."""

_CANDIDATES = 40
"""Number of tested places along the image's width."""

_SURROUNDINGS = 1.3
"""The depth must be known and smooth up to this distance, in radii of the spot."""

_MIN_RADIUS = 4.0
"""[px]"""

_ROUGHNESS_TOLERANCE = 1.5
"""Places with a roughness up to this multiple of the smallest count as equal; of these the nearest is used."""


@dataclass(frozen=True, eq=False)
class Spot:
    """Place and size of a spot.

    Attributes
    ----------
    row, column : int
    radius : float
        [px]
    depth : float
        Depth at its middle [m].
    focal : float
        Focal length used for the radius [px].
    nominal : bool
        Whether the focal length is nominal because the frame has none.
    roughness : float
        RMS deviation [m] of the depth around the middle from a quadric.
    """

    row: int
    column: int
    radius: float
    depth: float
    focal: float
    nominal: bool
    roughness: float

    def inside(self, shape: tuple[int, int], share: float = 1.0) -> NDArray[np.bool_]:
        """Pixels within `share` radii, bool (H, W)."""
        return self.distance(shape) <= share * self.radius

    def distance(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Distance of every pixel from the middle [px]."""
        rows, columns = np.indices(shape)
        return np.hypot(rows - self.row, columns - self.column)


def find_spot(frame: RGBDFrame) -> Spot:
    """Find the place for a spot: known all around, smooth, and the nearest such place.

    Raises
    ------
    InputError
        If the frame has no such place.
    """
    height, width = frame.shape
    nominal = frame.intrinsics is None
    focal = NOMINAL_FOCAL * width if frame.intrinsics is None else frame.intrinsics.fx
    step = max(2, width // _CANDIDATES)
    found = []
    for row in range(step, height - step, step):
        for column in range(step, width - step, step):
            depth = float(frame.depth[row, column])
            if not np.isfinite(depth):
                continue
            spot = Spot(row, column, focal * DIAMETER / 2 / depth, depth, focal, nominal, 0.0)
            roughness = _roughness(frame.depth, spot)
            if roughness is not None:
                found.append(Spot(row, column, spot.radius, depth, focal, nominal, roughness))
    if not found:
        raise InputError(f"No place of {100 * DIAMETER:g} cm with all its depth known was found.")
    smooth = _ROUGHNESS_TOLERANCE * min(spot.roughness / spot.depth for spot in found)
    return min((spot for spot in found if spot.roughness / spot.depth <= smooth), key=lambda spot: spot.depth)


def with_spot(frame: RGBDFrame, spot: Spot, glare: bool) -> RGBDFrame:
    """Remove the spot's depth from the frame; with glare, also saturate its colour as by a lamp, fading at the rim."""
    hole = spot.inside(frame.shape)
    rgb = frame.rgb
    if glare:
        light = np.clip((1.15 - spot.distance(frame.shape) / spot.radius) / 0.3, 0, 1)[..., None]
        rgb = np.round((1 - light) * rgb + light * 255).astype(np.uint8)
    return RGBDFrame(rgb, np.where(hole, np.nan, frame.depth), frame.intrinsics, frame.name)


def _roughness(depth: NDArray[np.float32], spot: Spot) -> float | None:
    """Deviation of the depth around a spot from a quadric [m]; None if the spot is too small or depth is missing."""
    reach = int(np.ceil(_SURROUNDINGS * spot.radius))
    rows = slice(spot.row - reach, spot.row + reach + 1)
    columns = slice(spot.column - reach, spot.column + reach + 1)
    part = depth[rows, columns] if min(rows.start, columns.start) >= 0 else depth[:0]
    if spot.radius < _MIN_RADIUS or part.shape != (2 * reach + 1, 2 * reach + 1):
        return None
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1] / reach
    disk = np.hypot(y, x) <= 1
    values = part[disk].astype(np.float64)
    if not np.isfinite(values).all():
        return None
    sparse = slice(None, None, max(1, values.size // 400))
    y, x, values = y[disk][sparse], x[disk][sparse], values[sparse]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    coefficients, *_ = np.linalg.lstsq(terms, values)
    return float(np.sqrt(np.mean((values - terms @ coefficients) ** 2)))
