"""One picture: exact depth through the centres of the pixels, and colour with its edges smoothed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera import Camera
from .develop import developed
from .light import Lighting, irradiance, openness, smoothed
from .shapes import unit
from .world import OFF_SURFACE, Hits, World, dot

FARTHEST = 60.0
"""Depth beyond which there is nothing [m]."""
BASELINE = 0.075
"""From the camera to the pattern projector on its right [m]."""


@dataclass(frozen=True)
class Picture:
    """What one camera sees, each (H, W) or (H, W, 3).

    Parameters
    ----------
    rgb : ndarray of uint8
        Colour.
    exact, behind : ndarray of float32
        Depth of the first surface, and of what is behind a transparent one, else NaN [m].
    normals : ndarray of float32
        Of the triangles, in camera coordinates, towards the camera.
    part : ndarray of int32
        Number of the smooth surface, -1 = none.
    object : ndarray of int32
        Number of the object whose surface it is; a wall or a floor is one too; -1 = none.
    flags : dict of ndarray of bool
        "black", "glossy", "transparent", "emitting".
    unlit : ndarray of bool
        Where a projector on the camera's right does not shine.
    intrinsics : tuple of float
        fx, fy, cx, cy [px].
    """

    rgb: np.ndarray
    exact: np.ndarray
    behind: np.ndarray
    normals: np.ndarray
    part: np.ndarray
    object: np.ndarray
    flags: dict[str, np.ndarray]
    unlit: np.ndarray
    intrinsics: tuple[float, float, float, float]


def photographed(
    world: World, lighting: Lighting, camera: Camera, size: tuple[int, int], rng: np.random.Generator
) -> Picture:
    """Picture of a world on (width, height) pixels."""
    width, height = size
    columns, rows = np.meshgrid(np.arange(width), np.arange(height))
    views = camera.rays(columns, rows)
    hits = world.cast(camera.position, views)
    seen = hits.found & (hits.distance < FARTHEST)
    shape = (height, width)
    exact = np.where(seen, hits.distance, np.nan).astype(np.float32).reshape(shape)
    table = world.table
    flags = {
        name: (getattr(table, name)[hits.material] & seen).reshape(shape)
        for name in ("black", "glossy", "transparent", "emitting")
    }
    part = np.where(hits.found, hits.part, -1).astype(np.int32).reshape(shape)
    projector = camera.position + BASELINE * camera.axes[0]
    start = hits.points + 3 * OFF_SURFACE * hits.flat
    unlit = (world.blocked(start, projector - start, 0.99) & seen).reshape(shape)
    radiance, behind = _coloured(world, lighting, camera, views, hits, part, rng)
    return Picture(
        rgb=developed(radiance, rng),
        exact=exact,
        behind=np.where(flags["transparent"], behind, np.nan).astype(np.float32),
        normals=(hits.flat @ camera.axes.T).astype(np.float32).reshape(height, width, 3),
        part=part,
        object=np.where(hits.found, hits.object, -1).astype(np.int32).reshape(shape),
        flags=flags,
        unlit=unlit,
        intrinsics=camera.intrinsics,
    )


def _coloured(
    world: World,
    lighting: Lighting,
    camera: Camera,
    views: np.ndarray,
    hits: Hits,
    part: np.ndarray,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Radiance, and depth behind glass: samples at centres and corners of the pixels, weighted half and half."""
    height, width = part.shape
    solid = world.cast(camera.position, views, through_glass=True) if world.has_glass else hits
    surfaces = np.where(solid.found, solid.part, -1).reshape(height, width)
    direct, shiny = _lamplight(world, lighting, solid, views, rng)
    direct = smoothed(direct.reshape(height, width, 3), surfaces, (1, 2))
    shiny = _softened(shiny.reshape(direct.shape), world.table.shine[solid.material].reshape(height, width), surfaces)
    open_ = smoothed(openness(world, lighting, solid, rng).reshape(height, width, 1), surfaces, (1, 3, 8))
    light = direct + lighting.ambient(solid.normals, open_.ravel()).reshape(height, width, 3)
    centres = _radiance(world, lighting, solid, views, light.reshape(-1, 3), shiny.reshape(-1, 3))
    centres = centres.reshape(light.shape)
    columns, rows = np.meshgrid(np.arange(width + 1) - 0.5, np.arange(height + 1) - 0.5)
    corner_views = camera.rays(columns, rows)
    corners = world.cast(camera.position, corner_views, through_glass=True)
    both = np.concatenate([light, shiny], axis=2)
    between = _radiance(
        world,
        lighting,
        corners,
        corner_views,
        *_from_around(world, lighting, corners, corner_views, surfaces, both, rng),
    )
    between = between.reshape(height + 1, width + 1, 3)
    radiance = 0.5 * centres + 0.125 * (between[:-1, :-1] + between[1:, :-1] + between[:-1, 1:] + between[1:, 1:])
    if world.has_glass:
        radiance = _through_glass(world, lighting, camera, views, hits, radiance, rng)
    behind = np.where(solid.found & (solid.distance < FARTHEST), solid.distance, np.nan).reshape(height, width)
    return radiance, behind


def _from_around(
    world: World,
    lighting: Lighting,
    corners: Hits,
    views: np.ndarray,
    part: np.ndarray,
    both: np.ndarray,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Light at the corners of pixels: that of the pixels around on the same surface; computed where there is none."""
    height, width = part.shape
    here = np.where(corners.found, corners.part, -1).reshape(height + 1, width + 1)
    total = np.zeros((height + 1, width + 1, 6), np.float32)
    weight = np.zeros((height + 1, width + 1, 1), np.float32)
    for down in (0, 1):
        for right in (0, 1):
            there = slice(down, down + height), slice(right, right + width)
            same = (here[there] == part)[..., None].astype(np.float32)
            total[there] += both * same
            weight[there] += same
    mean = (total / np.maximum(weight, 1)).reshape(-1, 6)
    alone = np.flatnonzero(weight.ravel() == 0)
    if alone.size:
        mean[alone] = np.concatenate(_light(world, lighting, corners.rows(alone), views[alone], rng), axis=1)
    return mean[:, :3], mean[:, 3:]


def _lamplight(
    world: World, lighting: Lighting, hits: Hits, views: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Light of the lamps, and radiance of what surfaces mirror: lamps and surroundings, (N, 3) each."""
    light, shiny = irradiance(world, lighting, hits, views, rng)
    gloss = world.table.gloss[hits.material]
    shiny *= gloss[:, None]
    mirrors = np.flatnonzero(hits.found & (gloss > 0.015))
    if mirrors.size:
        shiny[mirrors] += _mirrored(world, lighting, hits.rows(mirrors), views[mirrors], rng)
    return light, shiny


def _softened(shiny: np.ndarray, shine: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
    """What surfaces mirror (H, W, 3), evened out on those that are not polished: their rays scatter at random."""
    return np.where(
        (shine > 250)[..., None], shiny, smoothed(np.minimum(shiny, 4 * shiny.mean() + 1), surfaces, (1, 2, 4))
    )


def _light(
    world: World, lighting: Lighting, hits: Hits, views: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """All light that arrives, and radiance of what surfaces mirror, (N, 3) each."""
    direct, shiny = _lamplight(world, lighting, hits, views, rng)
    return direct + lighting.ambient(hits.normals, openness(world, lighting, hits, rng)), shiny


def _radiance(
    world: World, lighting: Lighting, hits: Hits, views: np.ndarray, light: np.ndarray, shiny: np.ndarray
) -> np.ndarray:
    """What surfaces send to the camera, (N, 3)."""
    table = world.table
    colour = table.colour(hits.material, hits.uv)
    radiance = colour * light * ((1 - table.gloss[hits.material]) / np.float32(np.pi))[:, None] + shiny
    emitting = np.flatnonzero(table.emitting[hits.material])
    radiance[emitting] = colour[emitting]
    radiance[~hits.found] = lighting.sky * (1 + 0.2 * views[~hits.found, 1:2])
    return radiance


def _mirrored(world: World, lighting: Lighting, hits: Hits, views: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """What glossy surfaces mirror, without shadows in it, (N, 3)."""
    gloss, shine = world.table.gloss[hits.material], world.table.shine[hits.material]
    sight = unit(views)
    normal = hits.normals + (0.4 / np.sqrt(shine))[:, None] * rng.standard_normal(views.shape, dtype=np.float32)
    normal = unit(normal)
    cosine = np.clip(-dot(sight, normal), 0, 1)
    away = sight + 2 * cosine[:, None] * normal
    share = gloss + (1 - gloss) * (1 - cosine) ** 5 * np.clip(shine / 200, 0, 1)
    seen = world.cast(hits.points + OFF_SURFACE * hits.flat, away, through_glass=True)
    colour = world.table.colour(seen.material, seen.uv)
    lit = lighting.ambient(seen.normals, np.ones(len(away), np.float32))
    for lamp in lighting.lamps:
        way, strength = lamp.arrives(seen.points, rng)
        lit = lit + 0.6 * strength * np.clip(dot(way, seen.normals) / np.linalg.norm(way, axis=1), 0, 1)[:, None]
    got = np.where(world.table.emitting[seen.material][:, None], colour, colour * lit / np.pi)
    return share[:, None] * np.where(seen.found[:, None], got, lighting.sky)


def _through_glass(
    world: World,
    lighting: Lighting,
    camera: Camera,
    views: np.ndarray,
    hits: Hits,
    radiance: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Glass over what is behind it: bent a little, tinted more where it is seen flat, with highlights at the rim."""
    shape = radiance.shape
    clear = np.flatnonzero(hits.found & world.table.transparent[hits.material])
    if not clear.size:
        return radiance
    glass, sight = hits.rows(clear), views[clear]
    straight = unit(sight)
    cosine = np.clip(-dot(straight, glass.normals), 0.05, 1)
    bent = straight - 0.25 * (glass.normals + cosine[:, None] * straight)
    behind = world.cast(glass.points, bent, through_glass=True)
    seen = _radiance(world, lighting, behind, bent, *_light(world, lighting, behind, bent, rng))
    tint = world.table.colour(glass.material, glass.uv) ** (0.5 + 0.5 / cosine[:, None])
    _, shiny = _lamplight(world, lighting, glass, sight, rng)
    gloss = world.table.gloss[glass.material][:, None]
    flat = radiance.reshape(-1, 3).copy()
    fresnel = gloss + (1 - gloss) * (1 - cosine[:, None]) ** 5
    flat[clear] = seen * np.clip(tint, 0, 1) * (1 - fresnel) + shiny
    return flat.reshape(shape)
