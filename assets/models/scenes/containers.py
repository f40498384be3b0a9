"""Boxes, bottles, cups and bags, each about the origin with its lowest point at height 0."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, height_of, moved, one_object, set_down, turned
from .shapes import any_rotation, ball, bar, joined, lathe, lump, rotation, sheet, sheets, standing, unit, wire
from .solids import brick, fruit


@one_object
def carton(kit: Kit) -> Parts:
    size = kit.between(0.03, 0.3), kit.between(0.03, 0.3), kit.between(0.02, 0.2)
    parts: Parts = [(standing(size), kit.materials.pack())]
    if kit.chance(0.15):
        lid = sheet(
            np.array(
                [[(-size[0] / 2, 0, 0), (size[0] / 2, 0, 0)], [(-size[0] / 2, 0.7, -0.7), (size[0] / 2, 0.7, -0.7)]]
            )
            * (1, size[2] * 0.6, size[2] * 0.6)
        )
        parts.append((lid.moved(0, size[1], -size[2] / 2), parts[0][1]))
    return parts


@one_object
def bottle(kit: Kit) -> Parts:
    radius, height = kit.between(0.02, 0.05), kit.between(0.12, 0.34)
    neck, shoulder = radius * kit.between(0.25, 0.6), height * kit.between(0.5, 0.8)
    body = kit.materials.one_of("glass", "plastic", "glaze", "black", "pack")
    top = shoulder + radius * kit.between(0.4, 1.2)
    profile = [(0, 0), (radius, 0), (radius, shoulder), (neck * 1.1, min(top, height - 0.03)), (neck, height - 0.02)]
    parts: Parts = [(lathe([*profile, (neck, height), (0, height)]), body)]
    if kit.chance(0.6):
        band = lathe([(radius * 1.01, shoulder * 0.15), (radius * 1.01, shoulder * kit.between(0.5, 0.9))])
        parts.append((band, kit.materials.pack()))
    if kit.chance(0.6):
        cap = lathe([(neck * 1.15, height - 0.025), (neck * 1.15, height + 0.005), (0, height + 0.005)], 14)
        parts.append((cap, kit.materials.plastic()))
    return parts


@one_object
def can(kit: Kit) -> Parts:
    radius, height = kit.between(0.025, 0.06), kit.between(0.04, 0.18)
    tin = lathe(
        [(0, height - 0.003), (radius * 0.93, height - 0.003), (radius * 0.95, height), (radius, height - 0.004)]
    )
    side = lathe([(radius, height - 0.004), (radius, 0), (0, 0)])
    return [(tin, kit.materials.metal()), (side, kit.materials.one_of("pack", "metal", "plastic", "glaze"))]


@one_object
def vessel(kit: Kit) -> Parts:
    """Cup, bowl, vase, plate, glass or pot: an open body of revolution with some wall."""
    radius = kit.between(0.03, 0.16)
    height = radius * kit.rng.choice([kit.between(0.15, 0.5), kit.between(0.8, 1.5), kit.between(2, 3.5)])
    foot, belly = kit.between(0.4, 0.95), kit.between(0.7, 1.25)
    wall = min(0.005, radius * 0.1)
    t = np.linspace(0, 1, 7)
    outline = radius * ((1 - t) ** 2 * foot + 2 * t * (1 - t) * belly + t**2)
    outside = [(r, height * h) for r, h in zip(outline, t, strict=True)]
    inside = [(max(r - wall, 0.004), height * h + wall * (1 - h)) for r, h in zip(outline, t, strict=True)][::-1]
    material = kit.materials.one_of("glaze", "glaze", "plastic", "metal", "glass", "wood", "black")
    parts: Parts = [(lathe([(0, 0), *outside, *inside, (0, wall)], 26), material)]
    if kit.chance(0.35) and height > 0.05:
        angle = np.linspace(-1.4, 1.4, 9)
        grip = np.stack(
            [outline[4] + 0.33 * height * np.cos(angle) - 0.004, height * (0.5 + 0.33 * np.sin(angle)), 0 * angle]
        )
        parts.append((wire(grip.T, height * 0.06 + 0.001), material))
    if kit.chance(0.4):
        level = kit.between(0.4, 0.9)
        surface = lathe([(0, height * level), (np.interp(level, t, outline) - wall, height * level)])
        parts.append((surface, kit.materials.one_of("paint", "black", "anything")))
    if kit.chance(0.25) and height < radius * 1.6:
        for _ in range(kit.number(2, 5)):
            r = radius * kit.between(0.25, 0.4)
            parts.append(
                (
                    ball((2 * r, 2 * r, 2 * r))
                    .moved(*kit.rng.normal(0, 0.3 * radius, 2), 0)
                    .turned(rotation(90, "x"))
                    .moved(y=height * 0.8),
                    kit.materials.paint(),
                )
            )
    return parts


@one_object
def bag(kit: Kit) -> Parts:
    size = kit.rng.uniform(0.08, 0.3, 3)
    return set_down(
        [(lump(size, kit.between(0.05, 0.25), kit.rng), kit.materials.one_of("cloth", "pack", "black", "paint"))]
    )


def open_box(width: float, depth: float, height: float, wall: float, material: int) -> Parts:
    floor = standing((width, wall, depth))
    sides = [standing((wall, height, depth)).moved(x=s * (width - wall) / 2) for s in (-1, 1)]
    ends = [standing((width - 2 * wall, height, wall)).moved(z=s * (depth - wall) / 2) for s in (-1, 1)]
    return [(joined([floor, *sides, *ends]), material)]


@one_object
def basket(kit: Kit) -> Parts:
    """Open box, perhaps with bars for sides, with things in it."""
    width, depth, height = kit.between(0.15, 0.4), kit.between(0.15, 0.4), kit.between(0.08, 0.25)
    material = kit.materials.one_of("plastic", "wood", "metal", "paint", "anything")
    parts = open_box(width, depth, height, kit.between(0.003, 0.015), material)
    for _ in range(kit.number(0, 5)):
        thing = kit.one_of((carton, bottle, fruit, brick, bag, can))(kit)
        parts += moved(
            set_down(turned(thing, any_rotation(kit.rng)), 0.01),
            *(kit.between(-0.3, 0.3) * side for side in (width, 0, depth)),
        )
    return parts


@one_object
def holder(kit: Kit) -> Parts:
    """Cup of pens."""
    radius, height = kit.between(0.03, 0.05), kit.between(0.08, 0.12)
    parts: Parts = [
        (
            lathe(
                [(0, 0), (radius, 0), (radius, height), (radius - 0.003, height), (radius - 0.003, 0.004), (0, 0.004)]
            ),
            kit.materials.one_of("plastic", "metal", "pack"),
        )
    ]
    for _ in range(kit.number(2, 8)):
        foot, tip = kit.rng.uniform(-0.5, 0.5, 2) * radius, kit.rng.uniform(-1, 1, 2) * radius
        parts.append(
            (
                bar((foot[0], 0.01, foot[1]), (tip[0], height * kit.between(1.2, 1.8), tip[1]), 0.004),
                kit.materials.one_of("plastic", "wood"),
            )
        )
    return parts


@one_object
def potted(kit: Kit) -> Parts:
    radius, height = kit.between(0.05, 0.2), kit.between(0.08, 0.35)
    pot = lathe(
        [
            (0, 0),
            (radius * kit.between(0.6, 1), 0),
            (radius, height),
            (radius * 0.9, height),
            (radius * 0.85, height * 0.85),
            (0, height * 0.85),
        ],
        26,
    )
    length = kit.between(1.5, 5) * radius
    blades = leaves(kit, kit.number(8, 50), length, length * kit.between(0.05, 0.45), lift=(kit.between(0.2, 1.0), 1.5))
    return [(pot, kit.materials.one_of("glaze", "plastic", "paint", "anything")), *moved(blades, y=height * 0.85)]


@one_object
def flowers(kit: Kit) -> Parts:
    parts = vessel(kit)
    height = height_of(parts)
    green, bloom = kit.materials.leaves(), kit.materials.paint()
    for _ in range(kit.number(3, 10)):
        x, z = kit.rng.normal(0, 0.1, 2)
        tip = np.array([x, height + kit.between(0.08, 0.3), z])
        parts.append((bar((0, height * 0.3, 0), tip, 0.002), green))
        parts.append((lump(kit.rng.uniform(0.025, 0.07, 3), 0.2, kit.rng).moved(*tip), bloom))
    return parts


def foliage(kit: Kit, size: np.ndarray, count: int, leaf: float) -> Parts:
    """Small leaves that fill an ellipsoid of a size (3,) about the origin, more of them near its surface."""
    away = kit.rng.standard_normal((count, 3))
    away *= (kit.rng.uniform(0.2, 1, (count, 1)) ** 0.4) / np.linalg.norm(away, axis=1, keepdims=True)
    along, across = unit(kit.rng.standard_normal((2, count, 3)))
    across = np.cross(along, across)
    s, a = np.linspace(-1, 1, 4)[:, None, None], np.array([-1.0, 0.0, 1.0])[:, None]
    half = 0.35 * np.sqrt(np.clip(1 - s**2, 0.01, 1))
    lengths = leaf * kit.rng.uniform(0.5, 1, (count, 1, 1, 1))
    blades = s * along[:, None, None] + half * a * across[:, None, None]
    return [(sheets((away * size / 2)[:, None, None] + 0.5 * lengths * blades), kit.materials.leaves())]


def leaves(kit: Kit, count: int, length: float, width: float, *, lift: tuple[float, float]) -> Parts:
    """Blades that rise from the origin and arch outwards."""
    rng, s = kit.rng, np.linspace(0, 1, 7)[None, :, None]
    a = np.array([-1.0, 0.0, 1.0])[None, None, :]
    size, rise, turn = (rng.uniform(*r, (count, 1, 1)) for r in ((0.5 * length, length), lift, (0, 2 * np.pi)))
    out, up = size * s * np.cos(rise * (1 - 0.7 * s)), size * s * np.sin(rise * (1 - 0.8 * s))
    half = (
        width
        / 2
        * rng.uniform(0.6, 1.1, (count, 1, 1))
        * np.sin(np.pi * np.clip(s, 0.04, 0.98) ** kit.between(0.6, 1.6))
    )
    side, up = half * a, up + 0.3 * half * np.abs(a)
    x, z = out * np.cos(turn) - side * np.sin(turn), out * np.sin(turn) + side * np.cos(turn)
    return [(sheets(np.stack(np.broadcast_arrays(x, up, z), axis=-1)), kit.materials.leaves())]
