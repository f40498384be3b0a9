"""Fruit, blocks, rings, and tools that lie."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, moved, one_object, set_down, turned
from .shapes import ball, bar, box, lathe, prism, rotation, wire


@one_object
def fruit(kit: Kit) -> Parts:
    size = np.array([1, kit.between(0.7, 1.4), 1]) * kit.between(0.04, 0.12)
    parts: Parts = [(ball(size).moved(y=size[1] / 2), kit.materials.one_of("paint", "anything", "plastic"))]
    if kit.chance(0.5):
        parts.append((bar((0, size[1] * 0.97, 0), (0.006, size[1] + 0.015, 0), 0.002), kit.materials.wood()))
    return parts


@one_object
def brick(kit: Kit) -> Parts:
    """Rounded block: soap, a sponge, a toy, a mouse."""
    size = kit.rng.uniform(0.03, 0.16, 3) * (1, 0.6, 1)
    body = ball(size, kit.between(0.15, 0.7)).moved(y=size[1] / 2)
    return [(body, kit.materials.one_of("paint", "plastic", "cloth", "black", "anything"))]


@one_object
def polygon(kit: Kit) -> Parts:
    """Prism, gear-like slab or wedge with a random outline."""
    angle = np.sort(kit.rng.uniform(0, 2 * np.pi, kit.number(3, 8)))
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1) * kit.rng.uniform(0.03, 0.1, 2)
    return [(prism(outline, kit.between(0.01, 0.2)), kit.materials.one_of("paint", "plastic", "pack", "metal", "wood"))]


@one_object
def ring(kit: Kit) -> Parts:
    """Roll of tape, a ring or a wheel, standing or lying."""
    radius, thick = kit.between(0.03, 0.1), kit.between(0.01, 0.06)
    hole = radius * kit.between(0.3, 0.85)
    body = lathe([(hole, 0), (radius, 0), (radius, thick), (hole, thick), (hole, 0)], 26)
    parts: Parts = [(body, kit.materials.one_of("plastic", "paint", "metal", "black", "pack"))]
    return set_down(turned(parts, rotation(90, "x") @ rotation(kit.between(0, 90)))) if kit.chance(0.3) else parts


@one_object
def tool(kit: Kit) -> Parts:
    """Screwdriver, hammer, brush, spoon or pen, lying."""
    grip, length = kit.between(0.004, 0.02), kit.between(0.08, 0.35)
    share = kit.between(0.3, 0.9)
    handle = bar((0, grip, 0), (length * share, grip, 0), grip)
    shaft = bar((length * share, grip, 0), (length, grip, 0), grip * kit.between(0.2, 0.8))
    parts: Parts = [(handle, kit.materials.one_of("plastic", "wood", "black")), (shaft, kit.materials.metal())]
    if kit.chance(0.6):
        head = kit.rng.uniform(0.5, 4, 3) * grip
        shape = ball(2 * head) if kit.chance(0.5) else box(2 * head)
        parts.append((shape.moved(length, max(grip, head[1]), 0), kit.materials.metal()))
    return turned(moved(parts, x=-length / 2), rotation(kit.between(0, 360)))


@one_object
def pliers(kit: Kit) -> Parts:
    """Scissors or tongs: two bent arms that cross."""
    arms, t = [], np.linspace(-1, 1, 14)
    spread, length = kit.between(0.01, 0.05), kit.between(0.06, 0.14)
    for side in (-1, 1):
        across = side * spread * np.sin(t * 2.4) * np.where(t < 0, 1, 0.5)
        arms.append(wire(np.stack([length * t, 0.008 + 0 * t, across], axis=-1), kit.between(0.003, 0.008)))
    return turned([(arm, kit.materials.one_of("plastic", "metal")) for arm in arms], rotation(kit.between(0, 360)))
