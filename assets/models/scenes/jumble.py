"""Kind of scene: nothing in particular."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, moved, turned
from .setting import Setting
from .shapes import any_rotation, ball, bar, beam, box, lump, rotation, sheet
from .small_things import SMALL


def jumble(kit: Kit) -> Setting:
    """Nothing in particular: bodies of all sizes in the air before slanted planes."""
    parts: Parts = []
    for _ in range(kit.number(1, 4)):
        turn = (
            any_rotation(kit.rng)
            if kit.chance(0.4)
            else rotation(kit.rng.normal(0, 30)) @ rotation(kit.rng.normal(0, 15), "x")
        )
        parts.append(
            (
                box((14, 10, 0.1)).turned(turn).moved(0, 0, kit.between(1.5, 6)),
                kit.materials.one_of("wall", "anything", "rug"),
            )
        )
    parts.append((box((16, 12, 0.1)).moved(0, 0, 7), kit.materials.anything()))
    parts.append(
        (
            box((16, 0.1, 16)).turned(rotation(kit.rng.normal(0, 8), "x")).moved(0, -kit.between(0.4, 2), 3),
            kit.materials.floor(),
        )
    )
    thin = kit.between(0, 0.4)
    for _ in range(kit.number(8, 70)):
        size, away = float(np.exp(kit.between(np.log(0.04), np.log(0.8)))), kit.between(0.6, 4.5)
        at = np.array([kit.between(-0.6, 0.6) * away, kit.between(-0.5, 0.5) * away, away])
        kind, sides = kit.number(0, 5), size * kit.rng.uniform(0.1, 1, 3)
        if kit.chance(thin):
            end = at + size * 3 * kit.rng.normal(0, 1, 3)
            shape = (
                bar(at, end, kit.between(0.002, 0.03))
                if kit.chance(0.6)
                else beam(at, end, kit.between(0.005, 0.1), 0.01)
            )
            parts.append((shape, kit.materials.one_of("anything", "paint", "metal", "black")))
            continue
        if kind == 5:
            parts += moved(turned(kit.one_of(SMALL)(kit), any_rotation(kit.rng)), *at)
            continue
        shape = (
            box(sides), ball(sides, kit.between(0.2, 1.0)), bar((0, 0, 0), sides * 2, size * 0.15),
            lump(sides, 0.2, kit.rng), sheet(_bent(kit, size)),
        )[kind]  # fmt: skip
        parts.append(
            (
                shape.turned(any_rotation(kit.rng)).moved(*at),
                kit.materials.one_of("anything", "anything", "paint", "plastic", "metal", "glass", "black", "cloth"),
            )
        )
    return Setting(
        parts,
        (np.array([-0.2, -0.2, -0.3]), np.array([0.2, 0.2, 0.2])),
        (np.array([-0.7, -0.5, 3]), np.array([0.7, 0.5, 4])),
        roll=25,
    )


def _bent(kit: Kit, size: float) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-1, 1, 16), np.linspace(-1, 1, 16))
    z = (
        kit.rng.normal(0, 0.4) * x * x
        + kit.rng.normal(0, 0.3) * y * y
        + kit.rng.normal(0, 0.15) * np.sin(5 * x + 3 * y)
    )
    return np.stack([x, y * kit.between(0.3, 1), z], axis=-1) * size
