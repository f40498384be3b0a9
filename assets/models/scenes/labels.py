"""Where exact depth jumps from one surface to another, and where surfaces meet at an angle."""

from __future__ import annotations

import math

import numpy as np

from ilf.data.pixel_grids import Pairs, long_lines, mark, sides

JUMP, JUMP_SHARE = 0.02, 0.02
"""Smallest jump [m], and as a share of the nearer depth; the larger of both counts."""
CREASE = math.cos(math.radians(25))
"""Cosine of the smallest angle between two surfaces that counts as a crease."""
CREASE_LENGTH = 12
"""Creases are lines longer than this [px]; shorter ones are slivers of things finer than a pixel."""


def label(
    exact: np.ndarray, normals: np.ndarray, part: np.ndarray, K: np.ndarray | tuple[float, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Jumps and creases of exact depth, as lines 1 px wide (`ilf.data.pixel_grids.mark`).

    Neighbours jump where neither tangent plane leads from one to the other, or where one of them is sky. A smooth
    surface that turns away between two pixels is bounded by both planes, so it does not jump from itself there.
    Surfaces crease where they do not jump and their normals differ.

    Parameters
    ----------
    exact : ndarray, shape (H, W)
        Depth [m], NaN = sky.
    normals : ndarray, shape (H, W, 3)
        Geometric normals in camera coordinates; either sign.
    part : ndarray of int, shape (H, W)
        Which smooth surface it is; one surface has no creases.
    K : sequence of float
        fx, fy, cx, cy [px].

    Returns
    -------
    jump, crease : ndarray of uint8, shape (H, W)
        1 on the lines.
    """
    depth, normals = np.asarray(exact, np.float32), np.asarray(normals, np.float32)
    rays = _rays(depth.shape, K)
    away = np.einsum("...k,...k->...", normals, rays) > 0
    normals = np.where(away[..., None], -normals, normals)
    across, down = (
        _pairs(*values) for values in zip(sides(depth), sides(normals), sides(part), sides(rays), strict=True)
    )
    jumps: Pairs = across[0], down[0]
    creases = long_lines((across[1], down[1]), CREASE_LENGTH)
    return mark(jumps).astype(np.uint8), mark(creases).astype(np.uint8)


def _rays(shape: tuple[int, ...], K: np.ndarray | tuple[float, ...]) -> np.ndarray:
    fx, fy, cx, cy = (float(value) for value in K)
    rows, columns = np.indices(shape, np.float32)
    return np.stack([(columns - cx) / fx, (rows - cy) / fy, np.ones(shape, np.float32)], axis=-1)


def _pairs(
    depth: tuple[np.ndarray, np.ndarray],
    normals: tuple[np.ndarray, np.ndarray],
    part: tuple[np.ndarray, np.ndarray],
    rays: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Which neighbours jump, and which crease."""
    (one, other), smooth = depth, part[0] == part[1]
    step = other - one
    led = _on_plane(one, normals[0], *rays) - one
    back = other - _on_plane(other, normals[1], *rays[::-1])
    least = np.maximum(JUMP, JUMP_SHARE * np.minimum(one, other))
    explained = np.fmin(np.abs(step - led), np.abs(step - back)) <= least
    between = (np.fmin(led, back) - least <= step) & (step <= np.fmax(led, back) + least)
    here, there = np.isfinite(one), np.isfinite(other)
    jump = (here ^ there) | (here & there & ~explained & ~(smooth & between))
    cosine = np.einsum("...k,...k->...", *normals)
    return jump, here & there & ~jump & ~smooth & (cosine < CREASE)


def _on_plane(depth: np.ndarray, normal: np.ndarray, ray: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Depth of another ray on the tangent plane of a point; NaN where it does not meet it in front."""
    along = np.einsum("...k,...k->...", normal, ray)
    met = np.einsum("...k,...k->...", normal, other)
    ratio = np.divide(along, met, out=np.full_like(along, np.nan), where=met < -1e-6)
    return depth * ratio
