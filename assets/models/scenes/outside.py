"""Kind of scene: ground, house fronts, steps, bushes and trees under the sky."""

from __future__ import annotations

import numpy as np

from .containers import foliage, leaves
from .figures import big_plant, floor_lamp, person
from .frames import bicycle
from .parts import Ground, Kit, Parts, moved, one_object, turned
from .seats import chair
from .setting import Setting
from .shapes import bar, joined, lump, rotation, standing
from .storage import box_pile, table
from .walls import column, one_wall, railing


def outdoors(kit: Kit) -> Setting:
    """Ground, house fronts, steps, walls, railings, columns, bushes and trees under the sky."""
    parts: Parts = [(standing((60, 0.1, 60)).moved(0, -0.1, 20), kit.materials.one_of("street", "street", "grass"))]
    if kit.chance(0.75):
        front, _ = one_wall(kit, 14, kit.between(3, 7), kit.materials.one_of("wall", "street", "wood"))
        parts += turned(moved(front, -7, 0, kit.between(3, 11)), rotation(kit.rng.normal(0, 25)))
    if kit.chance(0.5):
        rise, tread, count, wide = kit.between(0.12, 0.2), kit.between(0.25, 0.4), kit.number(3, 14), kit.between(1, 5)
        steps = [standing((wide, rise * (n + 1), tread)).moved(0, 0, n * tread) for n in range(count)]
        steps.append(standing((wide, rise * count, 3)).moved(0, 0, count * tread + 1.4))
        flight: Parts = [(joined(steps), kit.materials.street())]
        if kit.chance(0.6):
            flight += moved(turned(railing(kit, count * tread + 0.5, rise / tread), rotation(-90)), wide / 2, 0, 0)
        parts += turned(moved(flight, kit.between(-2, 2), 0, kit.between(1.5, 4)), rotation(kit.rng.normal(0, 25)))
    for _ in range(kit.number(0, 2)):
        low = standing((kit.between(1, 6), kit.between(0.4, 1.8), kit.between(0.15, 0.4)))
        parts.append(
            (
                low.turned(rotation(kit.between(0, 180))).moved(kit.between(-5, 5), 0, kit.between(2, 9)),
                kit.materials.one_of("street", "wall", "wood"),
            )
        )
    if kit.chance(0.5):
        parts += moved(
            turned(railing(kit, kit.between(2, 6), 0.0), rotation(kit.rng.normal(0, 30))),
            kit.between(-4, 0),
            0,
            kit.between(1.5, 6),
        )
    ground = Ground(kit, (-5, 5), (1.8, 10))
    for _ in range(kit.number(1, 9)):
        thing = kit.one_of(OUTSIDE)(kit)
        parts += ground.put(turned(thing, rotation(kit.between(0, 360))), 0.6)
    return Setting(
        parts,
        (np.array([-2, 0.8, -1.5]), np.array([2, 2.0, 0.5])),
        (np.array([-2.5, 0.2, 3]), np.array([2.5, 1.8, 8])),
        inside=False,
    )


@one_object
def bush(kit: Kit) -> Parts:
    size = kit.rng.uniform(0.4, 1.6, 3)
    core = lump(0.8 * size, 0.2, kit.rng).moved(y=size[1] * 0.4)
    return [
        (core, kit.materials.grass()),
        *_green(kit, size),
    ]


def _green(kit: Kit, size: np.ndarray) -> Parts:
    """Blades or small leaves all over a bush."""
    if kit.chance(0.4):
        return leaves(kit, kit.number(60, 250), float(size.max()) * 0.7, 0.08, lift=(0.0, 1.6))
    return moved(foliage(kit, 1.1 * size, kit.number(200, 900), kit.between(0.04, 0.15)), y=size[1] * 0.4)


@one_object
def tree(kit: Kit) -> Parts:
    height, bark = kit.between(1.5, 4), kit.materials.wood()
    parts: Parts = [(bar((0, 0, 0), (kit.rng.normal(0, 0.1), height, 0), kit.between(0.05, 0.2), 0.03), bark)]
    for _ in range(kit.number(3, 9)):
        tip = kit.rng.normal((0, height, 0), 0.6)
        parts.append((bar((0, height * kit.between(0.4, 0.9), 0), tip, 0.025, 0.008), bark))
        if kit.chance(0.5):
            parts += moved(leaves(kit, kit.number(15, 60), 0.6, 0.1, lift=(-1.0, 1.6)), *tip)
        else:
            crown = foliage(kit, kit.rng.uniform(0.5, 1.4, 3), kit.number(60, 250), kit.between(0.06, 0.16))
            parts += moved(crown, *tip)
    return parts


@one_object
def trunk(kit: Kit) -> Parts:
    """Stem of a large tree, whose crown is above the picture."""
    radius, height = kit.between(0.08, 0.35), kit.between(3, 6)
    return [(bar((0, 0, 0), (kit.rng.normal(0, 0.3), height, 0), radius, 0.7 * radius), kit.materials.bark())]


OUTSIDE = (
    bush, tree, trunk, trunk, column, bush, tree, person, person, big_plant, floor_lamp, box_pile, bicycle, table,
    table, table, chair,
)  # fmt: skip
"""What stands under the sky."""
