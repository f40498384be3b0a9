"""What a depth camera, drawn at random, makes of exact depth."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import cv2
import numpy as np

from . import depth_cameras, gaps
from .view import SKY, View, facing, patches, smooth_noise

CAMERAS = {
    depth_cameras.structured_light: 0.46,
    depth_cameras.stereo: 0.28,
    depth_cameras.time_of_flight: 0.16,
    depth_cameras.filled: 0.1,
}
"""How often each is drawn."""
MISREGISTERED = 0.4
"""Share of the pictures whose depth does not lie exactly on the colour."""

FARTHER = 1.05
"""Depth beyond the farthest that is there, times this, is no measurement."""

DESPECKLED = 0.75
"""Share of the pictures whose gaps of single pixels are closed, and whose single pixels are removed."""


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
    missing = gaps.together([lost, *causes], rng)
    if rng.random() < DESPECKLED:
        missing = cv2.medianBlur(missing.astype(np.uint8), 3) > 0
    there = met < SKY
    # at the rim of the sky, matching mixes its depth in; no camera measures beyond its range
    missing |= ~there | (depth > FARTHER * met.max(initial=0, where=there))
    measured = np.where(missing, np.nan, depth).astype(np.float32)
    return misregistered(measured, rng) if rng.random() < MISREGISTERED else measured


def _through_glass(
    exact: np.ndarray, behind: np.ndarray, transparent: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Depth that light meets, and what is lost in and around transparent things: each is looked through, lost, or
    shimmers, often in patches."""
    met = np.where(np.isfinite(exact), exact, SKY).astype(np.float32)
    if not transparent.any():
        return met, transparent
    far = np.where(np.isfinite(behind), behind, SKY).astype(np.float32)
    each = patches(transparent, rng) + rng.uniform(0.2, 0.8) * smooth_noise(exact.shape, rng.uniform(4, 20), rng)
    shimmer = rng.uniform(0.005, 0.05) * smooth_noise(exact.shape, rng.uniform(2, 8), rng)
    through = np.where(each > 0.4, far, met * (1 + shimmer))
    lost = transparent & (each < rng.uniform(-0.2, 0.4))
    side = int(rng.choice([1, 1, 3, 5, 7]))
    around = cv2.dilate(lost.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))) > 0
    return np.where(transparent, through, met), around


def misregistered(measured: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Depth moved by some pixels, more what is near, and scaled; missing where none came to lie.

    The surfaces near the median depth move by up to 2.5 px, those at half of it by up to 1.5 px more.
    """
    height, width = measured.shape
    rows, columns = np.nonzero(np.isfinite(measured))
    if not rows.size:
        return measured
    depth = measured[rows, columns]
    scale = 1 + rng.normal(0, 0.004)
    shift, drift = rng.uniform(0, 2.5) * rng.uniform(-1, 1, 2) * (1, 0.5), rng.uniform(-1.5, 1.5)
    nearer = np.minimum(np.median(depth) / depth - 1, 1.5)
    x = width / 2 + scale * (columns - width / 2) + shift[0] + drift * nearer
    y = height / 2 + scale * (rows - height / 2) + shift[1]
    moved = np.full((height + 2, width + 2), np.inf, np.float32)
    # Rounded two ways along each axis, since neighbours that drift apart would leave a line between them.
    for down, right in itertools.product((0.3, 0.7), repeat=2):
        row, column = np.floor(y + down).clip(-1, height), np.floor(x + right).clip(-1, width)
        np.minimum.at(moved, (row.astype(int) + 1, column.astype(int) + 1), depth)
    moved = moved[1:-1, 1:-1]
    return np.where(np.isfinite(moved), moved, np.float32(np.nan))
