"""A whole scene and its picture from two numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .camera import Camera, aimed
from .layouts import LAYOUTS
from .materials import Materials, Table
from .parts import Kit
from .picture import FARTHEST, Picture, photographed
from .setting import Setting, lighting
from .world import World

CANDIDATES = 6
"""Cameras tried in one scene before another is made."""
GLANCE = 1 / 8
"""Pixels along a side, as a share, with which a view is judged before it is taken."""


def picture(
    seed: int, number: int, size: tuple[int, int], kinds: Sequence[str] = ()
) -> tuple[Picture, np.random.Generator]:
    """Picture `number` of a seed on (width, height) pixels, and what its sensor's chance comes from.

    It is of one of the `kinds` of scene, names in `LAYOUTS`; none = all of them.

    Scenes whose views are blank, too near or in a wall are made again, with the chance that follows.
    """
    rng = np.random.default_rng([seed, number])
    names, shares = zip(*((one, share) for one, share in LAYOUTS if not kinds or one.__name__ in kinds), strict=True)
    while True:
        kit = Kit(rng, Materials(rng))
        setting = names[rng.choice(len(names), p=np.array(shares) / sum(shares))](kit)
        light = lighting(kit, setting)
        world = World(setting.parts, Table(kit.materials.rows))
        camera = _view(world, setting, size, kit)
        if camera is None:
            continue
        taken = photographed(world, light, camera, size, rng)
        if 12 < taken.rgb.mean() < 243 and taken.rgb.std() > 8:
            return taken, rng


def _view(world: World, setting: Setting, size: tuple[int, int], kit: Kit) -> Camera | None:
    """The better of two cameras that see enough, or None."""
    good: list[tuple[float, Camera]] = []
    for _ in range(CANDIDATES):
        position, target = kit.rng.uniform(*setting.stand), kit.rng.uniform(*setting.look)
        view = kit.between(25, 75) if kit.chance(0.5) else kit.between(50, 65)
        camera = aimed(position, target, float(kit.rng.normal(0, setting.roll)), view, size, kit.rng)
        worth = _worth(world, camera, size)
        if worth is not None:
            good.append((worth, camera))
        if len(good) == 2:
            break
    return max(good, key=lambda one: one[0])[1] if good else None


def _worth(world: World, camera: Camera, size: tuple[int, int]) -> float | None:
    """How much there is to see, or None where it is too little, too near or nothing."""
    width, height = (round(GLANCE * side) for side in size)
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    views = camera.scaled(GLANCE).rays(columns, rows)
    hits = world.cast(camera.position, views)
    depth = np.where(hits.found & (hits.distance < FARTHEST), hits.distance, np.nan)
    if np.isfinite(depth).mean() < 0.55 or np.nanpercentile(depth, 2) < 0.25:
        return None
    _, counts = np.unique(hits.part, return_counts=True)
    if counts.max() > 0.7 * len(depth) or len(counts) < 6 or np.nanmedian(depth) < 0.35:
        return None
    low, high = np.nanpercentile(depth, (5, 95))
    return len(counts) ** 0.5 * (0.3 + np.log(high / low))
