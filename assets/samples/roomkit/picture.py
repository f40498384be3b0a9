"""From radiance to the colour picture: supersampling, smoothing of light, exposure, camera noise."""

from __future__ import annotations

import cv2
import numpy as np

from . import light
from .room import Room
from .scene import dot, in_front

EXPOSURE = 0.78
GLASS = np.array([0.62, 0.80, 0.76])
"""Share of the light that passes through both walls of a glass at right angles."""


def render(
    room: Room, size: tuple[int, int], intrinsics: tuple[float, ...], rng: np.random.Generator, *, finer: int = 3
) -> np.ndarray:
    """Linear radiance (H, W, 3), `finer` x `finer` samples per pixel."""
    width, height = size[0] * finer, size[1] * finer
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    x, y = ((axis.ravel() + 0.5) / finer - 0.5 for axis in (columns, rows))
    views = room.camera.directions(x, y, intrinsics)
    hits = room.scene.cast(np.broadcast_to(room.camera.position, views.shape), views)
    lit = light.direct(room.scene, room.lights, hits, rng)
    soft = light.bounced(room.scene, room.lights, hits, rng, paths=2, bounces=3)
    lit, soft, normals, points = (
        a.reshape(height, width, 3).astype(np.float32) for a in (lit, soft, hits.normals, hits.points)
    )
    # Direct light keeps its shadows within two pixels; bounced light has no detail to lose.
    lit = smoothed(lit, normals, points, levels=2).reshape(-1, 3)
    soft = smoothed(soft, normals, points, levels=5).reshape(-1, 3)
    mirror, share = light.mirrored(
        room.scene, room.lights, hits, views, rng, sky=room.sky, ambient=soft.mean(axis=0), rays=6
    )
    surface = room.scene.colour(hits, textured=True) * (lit + soft) / np.pi + room.scene.of("emission", hits)
    seen = surface * (1 - share)[:, None] + mirror * share[:, None]
    seen = np.where(hits.found[:, None], seen, room.sky)
    glass = in_front(room.scene.cast(np.broadcast_to(room.camera.position, views.shape), views, glass=True), hits)
    mirror, share = light.mirrored(
        room.scene, room.lights, glass, views, rng, sky=room.sky, ambient=soft.mean(axis=0), rays=2
    )
    walls = 1 / np.maximum(-dot(views, glass.normals) / np.linalg.norm(views, axis=1), 0.1)
    passed = np.where(glass.found[:, None], GLASS ** walls[:, None], 1) * (1 - share)[:, None]
    seen = seen * passed + mirror * share[:, None]
    # Clipped before averaging, so that an edge against a lamp stays smooth.
    seen = np.minimum(seen * EXPOSURE, 12.0).reshape(size[1], finer, size[0], finer, 3)
    return seen.mean(axis=(1, 3)).astype(np.float32)


def smoothed(light_map: np.ndarray, normals: np.ndarray, points: np.ndarray, *, levels: int) -> np.ndarray:
    """Light averaged along its own surface: an a-trous wavelet filter that stops at edges."""
    kernel = np.array([1, 4, 6, 4, 1], np.float32) / 16
    current = light_map
    height, width = current.shape[:2]
    for level in range(levels):
        step = 2**level
        total, weight = np.zeros_like(current), np.zeros((height, width), np.float32)
        for i, j in np.ndindex(5, 5):
            dy, dx = (i - 2) * step, (j - 2) * step
            here = (slice(max(0, -dy), height - max(0, dy)), slice(max(0, -dx), width - max(0, dx)))
            there = (slice(max(0, dy), height - max(0, -dy)), slice(max(0, dx), width - max(0, -dx)))
            alike = np.maximum(np.einsum("hwi,hwi->hw", normals[here], normals[there]), 0) ** 24
            off = np.einsum("hwi,hwi->hw", normals[here], points[there] - points[here])
            share = kernel[i] * kernel[j] * alike * np.exp(-((off / 0.012) ** 2))
            total[here] += share[..., None] * current[there]
            weight[here] += share
        current = total / np.maximum(weight, 1e-6)[..., None]
    return current


def developed(radiance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """uint8 picture (H, W, 3), red first: glow, vignette, filmic curve, sensor noise."""
    height, width = radiance.shape[:2]
    bright = np.maximum(radiance - 1.0, 0)
    glow = sum(cv2.GaussianBlur(bright, (0, 0), s * width / 640) for s in (3.0, 12.0)) / 2
    linear = radiance + 0.10 * glow
    v, u = np.mgrid[:height, :width]
    radius = np.hypot((u + 0.5) / width - 0.5, (v + 0.5) / height - 0.5) / np.hypot(0.5, 0.5)
    linear = linear * (1 - 0.22 * radius**2.5)[..., None]
    # Narkowicz's fit of the ACES filmic curve.
    film = linear * (2.51 * linear + 0.03) / (linear * (2.43 * linear + 0.59) + 0.14)
    film = np.clip(film, 0, 1)
    srgb = np.where(film <= 0.0031308, 12.92 * film, 1.055 * film ** (1 / 2.4) - 0.055)
    sigma = 0.003 + 0.005 * np.sqrt(np.clip(1 - srgb, 0, 1))
    srgb = srgb + sigma * rng.standard_normal(srgb.shape)
    return np.clip(np.round(srgb * 255), 0, 255).astype(np.uint8)
