"""Kinds of scene: rooms, corridors, rows of seats, stairs."""

from __future__ import annotations

import numpy as np

from .devices import cable
from .furniture import BY_WALL, FREE
from .light import Lamp
from .parts import Ground, Kit, Parts, copied, extent, footprint, height_of, moved, one_object, scaled, turned
from .seats import chair, office_chair
from .setting import Setting
from .shapes import Shape, joined, rotation, standing
from .small_things import SMALL
from .storage import table
from .walls import hanging_lamp, painted, railing, rug, shell

ROWS = (table, table, chair, chair, chair, chair, office_chair, office_chair)
"""What stands in rows in meeting rooms."""


def furnished(kit: Kit, width: float, depth: float, height: float) -> Parts:
    """Furniture along the walls and in the middle."""
    parts: Parts = []
    ground = Ground(kit, (-width / 2 + 0.4, width / 2 - 0.4), (0.4, depth - 0.4))
    for turn, length, at in (
        (0, width, (0, depth)),
        (-90, depth, (-width / 2, depth / 2)),
        (90, depth, (width / 2, depth / 2)),
    ):
        x = -length / 2 + kit.between(0.3, 0.8)
        while x < length / 2 - 0.5:
            thing = kit.one_of(BY_WALL)(kit)
            reach = extent(thing)[1][2]
            half = max(-extent(thing)[0][0], extent(thing)[1][0])
            if height_of(thing) < height and x + 2 * half < length / 2:
                set_ = turned(moved(thing, x + half, 0, -reach - kit.between(0.01, 0.1)), rotation(turn))
                parts += moved(set_, at[0], 0, at[1])
            x += 2 * half + kit.rng.choice([kit.between(0.02, 0.3), kit.between(0.3, 1.5)])
    for _ in range(kit.number(0, 6)):
        parts += ground.put(turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360))))
    if kit.chance(0.5):
        parts += moved(rug(kit), kit.rng.normal(0, 0.5), 0.006, depth * kit.between(0.3, 0.7))
    for _ in range(kit.number(0, 10)):
        parts += ground.put(kit.one_of(SMALL)(kit))
    if kit.chance(0.3):
        cord = scaled(cable(kit), kit.between(1.5, 4))
        parts += moved(cord, kit.between(-0.3, 0.3) * width, 0, kit.between(0.3, 0.8) * depth)
    for _ in range(kit.rng.choice([0, 0, 1, 2])):
        parts += moved(hanging_lamp(kit), kit.between(-0.3, 0.3) * width, height, kit.between(0.3, 0.8) * depth)
    return parts


def room(kit: Kit) -> Setting:
    """A furnished room."""
    width, depth, height = kit.between(2.4, 6), kit.between(2.6, 7), kit.between(2.2, 3.2)
    parts = shell(kit, width, depth, height, kit.materials.wall())
    parts += furnished(kit, width, depth, height)
    lamp = Lamp(
        np.array([kit.between(-0.4, 0.4) * width, height - 0.15, kit.between(0.1, 0.9) * depth]),
        np.full(3, kit.between(1, 6)),
        float(kit.rng.choice([0.0, 0.15, 0.5])),
    )
    stand = np.array([-width / 2 + 0.3, 0.5, 0.2]), np.array([width / 2 - 0.3, min(2.0, height - 0.3), depth * 0.45])
    look = np.array([-width / 2, 0.1, depth * 0.5]), np.array([width / 2, 1.4, depth])
    return Setting(parts, stand, look, lamps=(lamp,))


def corridor(kit: Kit) -> Setting:
    """Long and narrow, with doors that stand open."""
    width, depth, height = kit.between(1.1, 2.4), kit.between(5, 14), kit.between(2.1, 2.9)
    parts = shell(kit, width, depth, height, kit.materials.wall())
    ground = Ground(kit, (-width / 2 + 0.25, width / 2 - 0.25), (1.5, depth - 0.4))
    for _ in range(kit.number(0, 6)):
        thing = kit.one_of(FREE + SMALL)(kit)
        if footprint(thing) < 0.6:
            parts += ground.put(thing)
    lamps = tuple(
        Lamp(np.array([0, height - 0.1, z]), np.full(3, kit.between(0.4, 2)), 0.1)
        for z in np.arange(kit.between(0.5, 3), depth, kit.between(3, 6))[:3]
    )
    stand = np.array([-width / 3, 0.8, 0.2]), np.array([width / 3, 1.9, depth * 0.4])
    return Setting(
        parts, stand, (np.array([-width / 2, 0.5, depth * 0.6]), np.array([width / 2, 1.6, depth])), lamps=lamps
    )


def seating(kit: Kit) -> Setting:
    """Rows of one kind of chair or table, as in a meeting room, and people."""
    width, depth, height = kit.between(4, 8), kit.between(5, 9), kit.between(2.4, 3.5)
    parts = shell(kit, width, depth, height, kit.materials.wall())
    thing, across, along, facing = (
        kit.one_of(ROWS),
        kit.between(0.6, 1.6),
        kit.between(0.8, 1.8),
        kit.between(0, 360),
    )
    one = thing(kit)
    for x in np.arange(-width / 2 + 0.7, width / 2 - 0.6, across):
        for z in np.arange(1.5, depth - 0.8, along):
            if kit.chance(0.75):
                parts += moved(
                    turned(copied(one), rotation(facing + kit.rng.normal(0, 8))), x + kit.rng.normal(0, 0.05), 0, z
                )
    for _ in range(kit.number(0, 3)):
        parts += moved(
            turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360))),
            kit.between(-0.4, 0.4) * width,
            0,
            kit.between(0.4, 0.9) * depth,
        )
    stand = np.array([-width / 2 + 0.4, 0.8, 0.2]), np.array([width / 2 - 0.4, 2.2, 1.2])
    return Setting(parts, stand, (np.array([-width / 3, 0.3, depth * 0.4]), np.array([width / 3, 1.0, depth])))


def stairwell(kit: Kit) -> Setting:
    """Steps indoors with walls, a landing and a railing, from below or above."""
    wide, rise, tread, count = kit.between(0.8, 1.8), kit.between(0.15, 0.2), kit.between(0.24, 0.32), kit.number(6, 14)
    paint = kit.materials.wall()
    closed = kit.chance(0.6)
    boxes = [
        standing((wide, rise if not closed else rise * (n + 1), tread)).moved(
            0, 0 if closed else rise * n, n * tread + 1
        )
        for n in range(count)
    ]
    parts: Parts = [(standing((14, 0.1, 20)).moved(0, -0.1, 5), kit.materials.floor()), *_flight(kit, boxes)]
    end = count * tread + 1
    parts.append((standing((14, 0.1, 20)).moved(0, 6, 5), kit.materials.ceiling()))
    parts.append((standing((14, 6, 0.1)).moved(0, 0, -kit.between(2.2, 4)), paint))
    parts.append((standing((wide + 3, rise * count, 2)).moved(0, 0, end + 1), paint))
    parts.append((standing((8, 6, 0.1)).moved(0, 0, end + kit.between(1.2, 2)), paint))
    parts.append((standing((0.1, 6, end + 8)).moved(-wide / 2 - 0.05, 0, end / 2), paint))
    parts.append(
        (
            standing((0.1, 6, end + 8)).moved(wide / 2 + (0.05 if kit.chance(0.4) else 2), 0, end / 2),
            kit.materials.wall(),
        )
    )
    parts += moved(turned(railing(kit, count * tread, rise / tread), rotation(-90)), wide / 2 - 0.05, 0, 1)
    for _ in range(kit.number(0, 4)):
        parts += moved(kit.one_of(SMALL)(kit), kit.between(-0.4, 0.4) * wide, 0, kit.between(-0.5, 0.9))
    top = rise * count
    if kit.chance(0.4):
        stand = np.array([-wide * 0.4, top + 1.2, end - 0.2]), np.array([wide * 0.4, top + 1.8, end + 0.8])
        return Setting(parts, stand, (np.array([-wide / 2, 0.0, -0.5]), np.array([wide / 2, 0.8 * top, end - 0.8])))
    stand = np.array([-wide * 0.4, 0.7, -2.0]), np.array([wide * 0.9, 2.0, 0.0])
    return Setting(parts, stand, (np.array([-wide / 2, 0.3, 1.5]), np.array([wide / 2, top, end])))


@one_object
def _flight(kit: Kit, steps: list[Shape]) -> Parts:
    """Steps, at times with a strip painted along the edge of each."""
    parts: Parts = [(joined(steps), kit.materials.one_of("wood", "floor", "street", "seamed"))]
    if kit.chance(0.4):
        wide = kit.rng.choice([0.03, 0.06])
        strip = painted(steps[0].high[0] - steps[0].low[0], wide).turned(rotation(90, "x"))
        strips = [strip.moved(step.low[0], step.high[1] + 0.001, step.low[2] + 0.01) for step in steps]
        parts.append((joined(strips), kit.materials.one_of("black", "paint", "metal")))
    return parts
