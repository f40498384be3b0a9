"""Surfaces that are known exactly, and what a sensor with noise and a continuous defect would see of them."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame

_LIGHT = np.array([-0.4, -0.5, -0.77])
"""Direction to the light: above the camera and left of it (x right, y down, z forward)."""

_COLOUR, _AMBIENT = np.array([205.0, 190.0, 170.0]), 0.25


@dataclass(frozen=True)
class Surface:
    """A part of a sphere, a cylinder or a plane as a height field: depth over an even grid, seen in parallel.

    Attributes
    ----------
    kind : str
        "sphere", "plane", "upright cylinder" (bent along rows) or "lying cylinder" (bent along columns).
    shape : tuple of int
        Pixels (H, W).
    size : tuple of float
        Height and width [m]; they need not have the aspect ratio of the pixels.
    distance : float
        Depth of the point that is nearest to the camera [m].
    radius : float
        [m]; of no meaning for a plane.
    """

    kind: str
    shape: tuple[int, int]
    size: tuple[float, float]
    distance: float
    radius: float

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth [m], shape (H, W)."""
        y, x = np.meshgrid(*(np.linspace(-0.5, 0.5, n) * s for n, s in zip(self.shape, self.size, strict=True)),
                           indexing="ij")  # fmt: skip
        squares = {
            "sphere": x**2 + y**2,
            "upright cylinder": x**2,
            "lying cylinder": y**2,
            "plane": np.zeros(self.shape),
        }[self.kind]
        return self.distance + self.radius - np.sqrt(self.radius**2 - squares)

    def describe(self) -> dict[str, Any]:
        """Name -> value, ready for JSON."""
        return asdict(self)


def shaded(surface: Surface) -> NDArray[np.uint8]:
    """Colour image of a matt surface under one light, uint8 (H, W, 3)."""
    pitches = (size / (count - 1) for size, count in zip(surface.size, surface.shape, strict=True))
    slope_y, slope_x = np.gradient(surface.depth, *pitches)
    normals = np.stack([slope_x, slope_y, -np.ones(surface.shape)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    light = np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)
    brightness = _AMBIENT + (1 - _AMBIENT) * light
    return np.round(brightness[..., None] * _COLOUR).astype(np.uint8)


def continuous_defect(shape: tuple[int, int], rate: float, along: str) -> NDArray[np.bool_]:
    """One gap in the middle: neighbouring whole columns ("x") or rows ("y") that make up this share of the pixels.

    At least one row or column is left on either side.
    """
    axis = {"y": 0, "x": 1}[along]
    count = shape[axis]
    wide = min(round(rate * count), count - 2)
    start = (count - wide) // 2
    inside = np.zeros(count, bool)
    inside[start : start + wide] = True
    return np.broadcast_to(inside[:, None] if along == "y" else inside, shape).copy()


def sensed(surface: Surface, noise: float, defect: NDArray[np.bool_], seed: int) -> RGBDFrame:
    """The surface with Gaussian noise of standard deviation `noise` [m], and the defect missing.

    The noise follows from the seed and its strength, so a growing defect leaves what is known as it was.
    """
    rng = np.random.default_rng([seed, round(1e6 * noise)])
    depth = surface.depth + noise * rng.standard_normal(surface.shape)
    return RGBDFrame(shaded(surface), np.where(defect, np.nan, depth), name=surface.kind)
