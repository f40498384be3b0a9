"""Parts of a sphere, a cylinder or a plane, exactly, and frames of them from a simulated sensor."""

import numpy as np
from numpy.typing import NDArray

from ilf import RGBDFrame

_LIGHT = np.array([-0.4, -0.5, -0.77]) / np.linalg.norm([-0.4, -0.5, -0.77])


def surface(kind: str, shape: tuple[int, int], size: tuple[float, float], distance: float, radius: float) -> NDArray:
    """Depth [m] in parallel projection of a "sphere" or an "upright cylinder"; `size` is height and width [m]."""
    y, x = np.meshgrid(*(np.linspace(-0.5, 0.5, n) * s for n, s in zip(shape, size, strict=True)), indexing="ij")
    squares = {"sphere": x**2 + y**2, "upright cylinder": x**2}[kind]
    return distance + radius - np.sqrt(radius**2 - squares)


def sensed(depth: NDArray, size: tuple[float, float], noise: float, hole: NDArray[np.bool_], name: str) -> RGBDFrame:
    """A frame of a matt surface under one light, with Gaussian noise [m] and without the depth of a hole."""
    slope_y, slope_x = np.gradient(depth, *(s / (n - 1) for n, s in zip(depth.shape, size, strict=True)))
    normals = np.stack([slope_x, slope_y, -np.ones(depth.shape)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    brightness = 0.25 + 0.75 * np.clip(normals @ _LIGHT, 0, 1)
    rgb = np.round(brightness[..., None] * [205.0, 190.0, 170.0]).astype(np.uint8)
    noisy = depth + noise * np.random.default_rng([0, round(1e6 * noise)]).standard_normal(depth.shape)
    return RGBDFrame(rgb, np.where(hole, np.nan, noisy), name=name)
