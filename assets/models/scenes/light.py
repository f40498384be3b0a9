"""Cheap light: a few lamps with one jittered shadow ray each, a hemisphere of ambient light, and highlights."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .shapes import unit
from .world import OFF_SURFACE, Hits, World, dot


@dataclass(frozen=True)
class Lamp:
    """A ball that shines.

    Parameters
    ----------
    position : ndarray (3,)
        Where it is [m]; of the sun, the direction to it.
    colour : ndarray (3,)
        Irradiance at 1 m; of the sun, anywhere.
    radius : float
        Size of the ball [m]: soft shadows.
    sun : bool
        Parallel light.
    target, cone : ndarray (3,), float
        Where a spot points, and the cosine of its half angle; -1 shines everywhere.
    panes : int
        Bright squares along each side of a spot, as of sunlight through a window; 0 = round.
    """

    position: np.ndarray
    colour: np.ndarray
    radius: float = 0.0
    sun: bool = False
    target: np.ndarray = field(default_factory=lambda: np.zeros(3))
    cone: float = -1.0
    panes: int = 0

    def arrives(self, points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Vectors to a random point of the lamp, and irradiance of a surface that faces it, (N, 3) each."""
        somewhere = self.position.astype(np.float32)
        if self.radius:
            somewhere = somewhere + np.float32(self.radius) * sphere(len(points), rng)
        if self.sun:
            way = np.broadcast_to(60 * somewhere, points.shape)
            return way, np.broadcast_to(self.colour.astype(np.float32), points.shape)
        way = somewhere - points
        strength = 1 / np.maximum(dot(way, way), 0.04)
        if self.panes:
            strength = strength * self._through_panes(-way)
        elif self.cone > -1:
            axis = self.target - self.position
            cosine = -dot(way, np.broadcast_to(axis, way.shape)) / np.sqrt(dot(way, way)) / np.linalg.norm(axis)
            strength = strength * np.clip((cosine - self.cone) / (1 - self.cone) * 4, 0, 1)
        return way, strength[:, None] * self.colour.astype(np.float32)

    def _through_panes(self, way: np.ndarray) -> np.ndarray:
        """Whether light that goes these ways passes the window."""
        ahead = unit(self.target - self.position)
        right = unit(np.cross([0.0, 1.0, 0.1], ahead))
        x, y, z = (way @ np.stack([right, np.cross(ahead, right), ahead]).T.astype(np.float32)).T
        reach = np.float32(np.tan(np.arccos(self.cone)))
        inside = z > 0
        for across in (x, y):
            place = (across / np.maximum(z, 1e-3) / reach + 1) / 2
            inside &= (place > 0) & (place < 1) & (np.abs((place * self.panes) % 1 - 0.5) < 0.45)
        return inside.astype(np.float32)


@dataclass(frozen=True)
class Lighting:
    """All light of a scene.

    Parameters
    ----------
    lamps : list of Lamp
        What casts shadows.
    above, below : ndarray (3,)
        Ambient irradiance of surfaces that face up and down.
    sky : ndarray (3,)
        Radiance where there is nothing.
    reach : float
        How far surfaces darken each other [m].
    """

    lamps: list[Lamp]
    above: np.ndarray
    below: np.ndarray
    sky: np.ndarray
    reach: float = 0.5

    def ambient(self, normals: np.ndarray, openness: np.ndarray) -> np.ndarray:
        """Irradiance without the lamps, (N, 3)."""
        up = 0.5 + 0.5 * normals[:, 1:2]
        light = (self.below + (self.above - self.below) * up).astype(np.float32)
        return light * (0.3 + 0.7 * openness[:, None])


def openness(world: World, lighting: Lighting, hits: Hits, rng: np.random.Generator) -> np.ndarray:
    """Whether a ray drawn at random leaves the surroundings, (N,) of 0 and 1: nooks are darker in the mean."""
    start = hits.points + OFF_SURFACE * hits.flat
    around = hits.flat + np.float32(0.98) * sphere(len(start), rng)
    return (~world.blocked(start, around * np.float32(lighting.reach))).astype(np.float32)


def irradiance(
    world: World, lighting: Lighting, hits: Hits, views: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Light of the lamps that arrives at points, and how much of it is mirrored as highlights, (N, 3) each."""
    start = hits.points + OFF_SURFACE * hits.flat
    total = np.zeros_like(hits.points)
    shiny = np.zeros_like(total)
    gloss = world.table.gloss[hits.material] > 0
    shine = world.table.shine[hits.material]
    for lamp in lighting.lamps:
        way, strength = lamp.arrives(hits.points, rng)
        length = np.sqrt(dot(way, way))
        facing = dot(way, hits.normals) / length
        lit = np.flatnonzero((facing > 0) & (dot(way, hits.flat) > 0) & (strength.max(axis=1) > 1e-4) & hits.found)
        lit = lit[~world.blocked(start[lit], way[lit], 0.995)]
        total[lit] += strength[lit] * facing[lit, None]
        here = lit[gloss[lit]]
        half = unit(way[here] / length[here, None] - unit(views[here]))
        spread = np.clip(dot(half, hits.normals[here]), 0, 1) ** shine[here] * (shine[here] + 8) / 25
        shiny[here] += strength[here] * np.minimum(spread, 40)[:, None]
    return total, shiny


def sphere(count: int, rng: np.random.Generator) -> np.ndarray:
    """Directions drawn evenly, (N, 3)."""
    height, turn = 2 * rng.random(count, dtype=np.float32) - 1, 2 * np.pi * rng.random(count, dtype=np.float32)
    ring = np.sqrt(1 - height * height)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)


def smoothed(values: np.ndarray, part: np.ndarray, steps: tuple[int, ...]) -> np.ndarray:
    """Values (H, W, channels) evened out within each smooth surface (H, W): means of three, `steps` pixels apart."""
    for step in steps:
        for axis in (0, 1):
            total, weight = values.copy(), np.ones((*part.shape, 1), np.float32)
            near = (slice(None),) * axis + (slice(step, None),)
            far = (slice(None),) * axis + (slice(None, -step),)
            same = (part[near] == part[far]).astype(np.float32)[..., None]
            total[near] += values[far] * same
            total[far] += values[near] * same
            weight[near] += same
            weight[far] += same
            values = total / weight
    return values
