"""What a depth camera, drawn at random, makes of exact depth."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from ilf.lab.training.surfaces.pictures import smooth_noise

from . import depth_cameras, gaps
from .view import SKY, View, facing, patches

CAMERAS = {
    depth_cameras.structured_light: 0.42,
    depth_cameras.stereo: 0.28,
    depth_cameras.time_of_flight: 0.16,
    depth_cameras.filled: 0.14,
}
"""How often each is drawn."""
MISREGISTERED = 0.4
"""Share of the pictures whose depth does not lie exactly on the colour."""


def sense(
    exact: np.ndarray,
    normals: np.ndarray,
    rgb: np.ndarray,
    flags: Mapping[str, np.ndarray],
    behind: np.ndarray,
    unlit: np.ndarray,
    K: np.ndarray | tuple[float, ...],
    rng: np.random.Generator,
) -> np.ndarray:
    """Depth as a camera measures it, with its own gaps.

    Parameters
    ----------
    exact : ndarray, shape (H, W)
        Depth [m], NaN = nothing there.
    normals : ndarray, shape (H, W, 3)
        In camera coordinates.
    rgb : ndarray of uint8, shape (H, W, 3)
        Colour; how bright a surface is decides how much light comes back.
    flags : mapping of str to ndarray of bool
        "black", "glossy", "transparent" and "emitting" surfaces, (H, W) each.
    behind : ndarray, shape (H, W)
        Depth [m] of what is behind transparent surfaces, NaN = nothing; not read elsewhere.
    unlit : ndarray of bool, shape (H, W)
        What a projector beside the camera does not reach.
    K : sequence of float
        fx, fy, cx, cy [px].
    rng : numpy.random.Generator
        Chooses the camera and all it does.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    """
    met, lost = _through_glass(exact, behind, flags["transparent"], rng)
    normals = np.asarray(normals, np.float32)
    seen_by = rng.dirichlet([2, 1, 1]).astype(np.float32) / 255
    view = View(met, normals, facing(normals, K), (rgb @ seen_by).astype(np.float32), flags, unlit)
    camera = list(CAMERAS)[int(rng.choice(len(CAMERAS), p=list(CAMERAS.values())))]
    depth, causes = camera(view, rng)
    missing = gaps.together([lost, *causes], rng) | (met >= SKY)
    measured = np.where(missing, np.nan, depth).astype(np.float32)
    return _misregistered(measured, rng) if rng.random() < MISREGISTERED else measured


def _through_glass(
    exact: np.ndarray, behind: np.ndarray, transparent: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Depth that light meets, and what is lost in transparent things: each is looked through, lost, or shimmers."""
    met = np.where(np.isfinite(exact), exact, SKY).astype(np.float32)
    if not transparent.any():
        return met, transparent
    far = np.where(np.isfinite(behind), behind, SKY).astype(np.float32)
    each = patches(transparent, rng) + rng.uniform(0.2, 0.8) * smooth_noise(exact.shape, rng.uniform(4, 20), rng)
    shimmer = rng.uniform(0.005, 0.05) * smooth_noise(exact.shape, rng.uniform(2, 8), rng)
    through = np.where(each > 0.9, far, met * (1 + shimmer))
    return np.where(transparent & (each > 0.3), through, met), transparent & (each < -0.2)


def _misregistered(measured: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Depth moved and scaled by some pixels, missing where it came from outside."""
    height, width = measured.shape
    scale = 1 + rng.normal(0, 0.006)
    shift = rng.uniform(0, 4) * np.array([rng.uniform(-1, 1), rng.uniform(-0.6, 0.6)])
    matrix = np.array([[scale, 0, (1 - scale) * width / 2 + shift[0]], [0, scale, (1 - scale) * height / 2 + shift[1]]])
    return cv2.warpAffine(measured, matrix, (width, height), flags=cv2.INTER_NEAREST, borderValue=float("nan"))
