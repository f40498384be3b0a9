"""Kinds of scene: tables, bins, shelves and worktops from near."""

from __future__ import annotations

import numpy as np

from .containers import open_box
from .furniture import FREE
from .parts import Kit, Parts, footprint, height_of, moved, scaled, set_down, turned
from .setting import Setting
from .shapes import any_rotation, joined, rotation, standing
from .small_things import LOOSE, SMALL
from .solids import pliers, tool
from .storage import cupboard_of, laid_out, shelf_of
from .walls import backdrop


def tabletop(kit: Kit) -> Setting:
    """A table full of things, seen from near."""
    width, depth, height = kit.between(0.8, 2.0), kit.between(0.6, 1.2), kit.between(0.4, 0.9)
    top = kit.materials.one_of("wood", "wood", "paint", "cloth", "anything", "black", "glaze", "rug")
    thick = kit.between(0.01, 0.08)
    parts: Parts = [(standing((width, thick, depth)).moved(0, height - thick, 0), top)]
    leg, places = standing((0.05, height - thick, 0.05)), [(x, z) for x in (-1, 1) for z in (-1, 1)]
    legs = [leg.moved(x * width * 0.46, 0, z * depth * 0.45) for x, z in places]
    parts.append((joined(legs), kit.materials.one_of("wood", "metal")))
    parts += laid_out(kit, width * 0.95, depth * 0.95, height, kit.number(4, 28), kit.one_of((SMALL, LOOSE, SMALL)))
    if kit.chance(0.6):
        parts += backdrop(kit, depth / 2 + 0.02, 0.8)
    else:
        parts += backdrop(kit, 0.8, 4)
    middle, reach = np.array([0, height, 0]), kit.between(0.5, 1.3)
    stand = np.add(middle, (-reach, 0.15 * reach, -reach)), np.add(middle, (reach, 1.1 * reach, -0.3 * reach))
    look = np.subtract(middle, (width * 0.3, 0, depth * 0.3)), np.add(middle, (width * 0.3, 0.15, depth * 0.4))
    return Setting(parts, stand, look, roll=5)


def picking(kit: Kit) -> Setting:
    """A bin with things thrown into it, or things on a mat, from above."""
    width, depth, height = kit.between(0.3, 0.8), kit.between(0.25, 0.6), kit.between(0.05, 0.3)
    parts: Parts = [
        (standing((6, 0.1, 6)).moved(0, -0.1, 0), kit.materials.one_of("floor", "wood", "black", "metal", "anything"))
    ]
    raised = kit.between(0, 0.9) if kit.chance(0.5) else 0.0
    if raised:
        parts.append(
            (
                standing((width * kit.between(1.1, 2.5), raised, depth * kit.between(1.1, 2.5))),
                kit.materials.one_of("wood", "metal", "paint", "black"),
            )
        )
    wall = kit.between(0.003, 0.03)
    if kit.chance(0.75):
        made_of = kit.materials.one_of("plastic", "wood", "metal", "paint", "black", "pack", "anything")
        parts += moved(open_box(width, depth, height, wall, made_of), y=raised)
    things = kit.one_of((LOOSE, LOOSE, SMALL))
    heights: list[tuple[float, float, float, float]] = []
    kinds = [kit.one_of(things) for _ in range(kit.number(1, 12))]
    for _ in range(kit.number(3, 40)):
        one = kit.one_of(kinds)(kit)
        turn = any_rotation(kit.rng) if kit.chance(0.6) else rotation(kit.between(0, 360))
        one = set_down(turned(one, turn))
        size = footprint(one)
        if size > 0.3 * max(width, depth):
            one = scaled(one, 0.3 * max(width, depth) / size)
            size = 0.3 * max(width, depth)
        x, z = (kit.between(-0.5, 0.5) * max(side - 1.6 * size, 0.02) for side in (width, depth))
        under = max(
            (top for a, b, r, top in heights if (a - x) ** 2 + (b - z) ** 2 < (0.7 * (r + size)) ** 2), default=wall
        )
        top = under + height_of(one)
        if top > height + 0.25:
            continue
        heights.append((x, z, size, under + 0.7 * (top - under)))
        parts += moved(one, x, raised + under, z)
    if kit.chance(0.3):
        parts += backdrop(kit, 1.0, 3.0)[1:]
    reach = kit.between(0.45, 1.2)
    stand = (
        np.array([-0.5 * reach, raised + 0.6 * reach, -0.7 * reach]),
        np.array([0.5 * reach, raised + reach + height, 0.0]),
    )
    return Setting(
        parts,
        stand,
        (np.array([-0.15, raised, -0.1]), np.array([0.15, raised + 0.1, 0.15])),
        roll=kit.rng.choice([4, 60]),
    )


def shelves(kit: Kit) -> Setting:
    """Shelves or cupboards from near."""
    parts = backdrop(kit, 0.45, 0.6)
    x = -2.0
    while x < 2:
        width, depth = kit.between(0.5, 1.6), kit.between(0.2, 0.45)
        maker = shelf_of if kit.chance(0.75) else cupboard_of
        parts += moved(maker(kit, width, kit.between(0.8, 2.3), depth), x + width / 2, 0, 0.42 - depth / 2)
        x += width + kit.rng.choice([0.0, 0.03, kit.between(0, 0.6)])
    for _ in range(kit.rng.choice([0, 0, 1, 2])):
        parts += moved(kit.one_of(FREE)(kit), kit.between(-1, 1), 0, -kit.between(0.4, 1.2))
    return Setting(
        parts,
        (np.array([-1.3, 0.5, -2.4]), np.array([1.3, 2.0, -0.5])),
        (np.array([-0.8, 0.3, 0.2]), np.array([0.8, 1.6, 0.4])),
    )


def worktop(kit: Kit) -> Setting:
    """Kitchen or workbench along a wall: cupboards below and above, things on it, tools on the wall."""
    parts = backdrop(kit, 0.32, 0.33)
    depth, height = kit.between(0.55, 0.65), kit.between(0.8, 0.95)
    parts += cupboard_of(kit, 4.5, height - 0.03, depth - 0.04)
    parts.append(
        (
            standing((4.5, 0.035, depth)).moved(0, height - 0.03, 0),
            kit.materials.one_of("wood", "glaze", "anything", "metal", "black"),
        )
    )
    parts += laid_out(kit, 3.2, depth * 0.7, height + 0.005, kit.number(5, 25))
    if kit.chance(0.6):
        over = cupboard_of(kit, kit.between(1, 4), kit.between(0.4, 0.8), 0.35)
        parts += moved(over, kit.between(-1, 1), height + kit.between(0.45, 0.65), depth / 2 - 0.18)
    for _ in range(kit.number(0, 10)):
        at = kit.between(-1.6, 1.6), height + kit.between(0.15, 0.6), 0.29
        hung = turned(kit.one_of((tool, tool, pliers))(kit), rotation(90, "x"))
        parts += moved(hung, *at)
    for _ in range(kit.number(0, 2)):
        parts += moved(
            turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360))),
            kit.between(-1.5, 1.5),
            0,
            -kit.between(0.8, 1.6),
        )
    return Setting(
        parts,
        (np.array([-1.5, 1.0, -2.5]), np.array([1.5, 2.0, -0.5])),
        (np.array([-1.0, 0.5, 0.0]), np.array([1.0, 1.4, 0.3])),
    )
