"""Light: lamps with soft shadows, bounces off the surfaces, mirror reflections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .scene import Hits, Scene, dot

OFF_SURFACE = 2e-4
"""Rays start this far above the surface [m], so that they do not meet it again."""


@dataclass(frozen=True)
class Area:
    """One-sided rectangle that glows."""

    corner: np.ndarray
    edges: tuple[np.ndarray, np.ndarray]
    radiance: np.ndarray
    normal: np.ndarray
    samples: int

    def sample(self, points: np.ndarray, jitter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Vectors to the light and the irradiance that a surface facing it would get, (N, 3) each."""
        towards = self.corner + jitter[:, :1] * self.edges[0] + jitter[:, 1:] * self.edges[1] - points
        area = np.linalg.norm(np.cross(*self.edges))
        square = dot(towards, towards)
        facing = np.maximum(-(towards @ self.normal), 0) / np.sqrt(square)
        # Held finite beside the light, where single samples would glare.
        square = np.maximum(square, 0.1)
        return towards, (area * facing / square)[:, None] * self.radiance


@dataclass(frozen=True)
class Bulb:
    """Small ball that shines alike in all directions."""

    position: np.ndarray
    radius: float
    intensity: np.ndarray
    samples: int

    def sample(self, points: np.ndarray, jitter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        towards = self.position + self.radius * _ball(jitter) - points
        return towards, self.intensity / np.maximum(dot(towards, towards), 0.01)[:, None]


@dataclass(frozen=True)
class Spot:
    """Narrow beam: full inside the radius `cone` at the target, then fading quickly."""

    position: np.ndarray
    target: np.ndarray
    radius: float
    cone: float
    intensity: np.ndarray
    samples: int

    def sample(self, points: np.ndarray, jitter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        towards = self.position + self.radius * _ball(jitter) - points
        axis = self.target - self.position
        reach = np.linalg.norm(axis)
        along = (points - self.position) @ (axis / reach)
        aside = np.linalg.norm(points - self.position - along[:, None] * (axis / reach), axis=1)
        share = aside / np.maximum(along, 1e-6) * reach / self.cone
        beam = np.where(along > 0, 1 / (1 + share**7) + 0.02 / (1 + share**2), 0.0)
        return towards, (beam / np.maximum(dot(towards, towards), 0.01))[:, None] * self.intensity


@dataclass(frozen=True)
class Sun:
    """Parallel light from the direction `towards`."""

    towards: np.ndarray
    radiance: np.ndarray
    spread: float
    samples: int

    def sample(self, points: np.ndarray, jitter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        unit = self.towards / np.linalg.norm(self.towards)
        towards = 40.0 * (unit + self.spread * _ball(jitter))
        return towards, np.broadcast_to(self.radiance, points.shape)


Light = Area | Bulb | Spot | Sun


def _ball(jitter: np.ndarray) -> np.ndarray:
    """Points on the unit sphere from two uniform numbers."""
    z, turn = 2 * jitter[:, 0] - 1, 2 * np.pi * jitter[:, 1]
    ring = np.sqrt(np.maximum(1 - z * z, 0))
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=1)


def from_one(
    scene: Scene, light: Light, hits: Hits, rng: np.random.Generator, stratum: tuple[int, int] = (0, 1)
) -> np.ndarray:
    """Irradiance of one shadow ray per point to one light, (N, 3); `stratum` is (number, count) of the ray."""
    number, count = stratum
    jitter = rng.random((len(hits.points), 2))
    # One ray per row and column of a count x count board, in a fixed order that spreads them.
    jitter = (jitter + np.array([number, (number * 5 + 2) % count])) / count
    towards, irradiance = light.sample(hits.points, jitter)
    facing = dot(towards, hits.normals) / np.linalg.norm(towards, axis=1)
    got = np.zeros_like(hits.points)
    # The geometric normal decides too: a smooth normal may see light that comes from behind its triangle.
    near = np.flatnonzero(hits.found & (facing > 0) & (dot(towards, hits.flat) > 0) & (irradiance.max(axis=1) > 1e-4))
    if near.size:
        start = hits.points[near] + OFF_SURFACE * hits.flat[near]
        free = near[~scene.blocked(start, towards[near], far=0.998)]
        got[free] = irradiance[free] * facing[free, None]
    return got


def direct(scene: Scene, lights: Sequence[Light], hits: Hits, rng: np.random.Generator) -> np.ndarray:
    """Irradiance from all lights with each one's number of shadow rays, (N, 3)."""
    total = np.zeros_like(hits.points)
    for light in lights:
        for number in range(light.samples):
            total += from_one(scene, light, hits, rng, (number, light.samples)) / light.samples
    return total


def _one_light_each(scene: Scene, lights: Sequence[Light], hits: Hits, rng: np.random.Generator) -> np.ndarray:
    """Irradiance from one light drawn at random per point, weighted to stand for all, (N, 3)."""
    total = np.zeros_like(hits.points)
    drawn = rng.integers(len(lights), size=len(hits.points))
    for number, light in enumerate(lights):
        here = np.flatnonzero(drawn == number)
        if here.size:
            total[here] = len(lights) * from_one(scene, light, _rows(hits, here), rng)
    return np.minimum(total, 30.0)


def _rows(hits: Hits, rows: np.ndarray) -> Hits:
    return Hits(**{name: value[rows] for name, value in vars(hits).items()})


def bounced(
    scene: Scene, lights: Sequence[Light], hits: Hits, rng: np.random.Generator, *, paths: int, bounces: int
) -> np.ndarray:
    """Irradiance by way of other surfaces, (N, 3): random paths of a few bounces."""
    total = np.zeros_like(hits.points)
    for _ in range(paths):
        rows, at, share = np.arange(len(hits.points)), hits, np.ones_like(hits.points)
        for _ in range(bounces):
            directions = at.normals + 0.999 * _ball(rng.random((len(rows), 2)))
            at = scene.cast(at.points + OFF_SURFACE * at.flat, directions)
            rows, share, at = rows[at.found], share[at.found], _rows(at, at.found)
            colour = scene.colour(at, textured=False)
            light = scene.of("emission", at) * np.pi + colour * _one_light_each(scene, lights, at, rng)
            total[rows] += share * light / paths
            share = share * colour
    return total


def mirrored(
    scene: Scene,
    lights: Sequence[Light],
    hits: Hits,
    views: np.ndarray,
    rng: np.random.Generator,
    *,
    sky: np.ndarray,
    ambient: np.ndarray,
    rays: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Radiance in the mirror direction and the share (N,) of it that glossy surfaces reflect."""
    gloss = scene.of("gloss", hits)
    rows = np.flatnonzero(hits.found & (gloss > 0))
    radiance, share = np.zeros_like(hits.points), np.zeros(len(hits.points))
    unit = views[rows] / np.linalg.norm(views[rows], axis=1, keepdims=True)
    near = _rows(hits, rows)
    roughness = scene.of("roughness", near)
    cos = np.clip(-dot(unit, near.normals), 0, 1)
    share[rows] = gloss[rows] + (1 - gloss[rows]) * (1 - cos) ** 5 * (1 - 4 * roughness)
    for _ in range(rays):
        normal = near.normals + roughness[:, None] * rng.standard_normal(near.normals.shape)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        away = unit - 2 * dot(unit, normal)[:, None] * normal
        seen = scene.cast(near.points + OFF_SURFACE * near.flat, away)
        light = sum(from_one(scene, lamp, seen, rng) for lamp in lights) + ambient
        got = scene.of("emission", seen) + scene.colour(seen, textured=True) * light / np.pi
        radiance[rows] += np.where(seen.found[:, None], got, sky) / rays
    return radiance, share
