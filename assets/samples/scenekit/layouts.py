"""Kinds of scene, each made anew at random."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .furniture import BY_WALL, FREE, cupboard_of, hanging, laid_out, shelf_of, table
from .light import Lamp
from .parts import Ground, Kit, Parts, extent, footprint, height_of, moved, scaled, set_down, turned
from .setting import Setting
from .shapes import any_rotation, ball, bar, beam, box, joined, lathe, lump, rotation, sheet, standing
from .small_things import LOOSE, SMALL, leaves, open_box

Opening = tuple[float, float, float, float]
"""Left, right, bottom and top of a hole in a wall [m]."""


def wall_with(width: float, height: float, thick: float, openings: list[Opening]) -> Parts | list:
    """Boxes of a wall in the plane z = 0 .. thick, its left lower corner at the origin, around openings side by side."""
    boxes, x = [], 0.0
    for left, right, low, high in sorted(openings):
        boxes.append(standing((left - x, height, thick)).moved((x + left) / 2))
        if low > 0:
            boxes.append(standing((right - left, low, thick)).moved((left + right) / 2))
        boxes.append(standing((right - left, height - high, thick)).moved((left + right) / 2, high))
        x = right
    boxes.append(standing((width - x, height, thick)).moved((x + width) / 2))
    return joined(boxes).moved(z=thick / 2)


def door_leaf(kit: Kit, width: float, height: float, turn: float) -> Parts:
    """Door hung at the origin that opens by a turn [degrees]."""
    leaf = standing((width, height, 0.04)).moved(x=width / 2)
    knob = bar((width - 0.1, 1.0, -0.07), (width - 0.1, 1.0, 0.07), 0.012)
    parts: Parts = [(leaf, kit.materials.one_of("wood", "paint", "wall")), (knob, kit.materials.metal())]
    if kit.chance(0.4):
        panels = [box((width * 0.6, height * 0.35, 0.05)).moved(width / 2, height * y) for y in (0.28, 0.72)]
        parts.append((joined(panels), parts[0][1] if kit.chance(0.6) else kit.materials.glass()))
    return turned(parts, rotation(turn))


def one_wall(kit: Kit, width: float, height: float, paint: int) -> tuple[Parts, list[Opening]]:
    """Wall from x = 0 to `width` seen from -z, with doors, windows, pictures, skirting; also its doors."""
    thick, openings, parts = kit.between(0.08, 0.3), [], []
    doors: list[Opening] = []
    x = kit.between(0.1, 1.0)
    while x < width - 0.9:
        wide = kit.between(0.7, 1.6)
        if x + wide > width - 0.15:
            break
        if kit.chance(0.25):
            opening = (x, x + min(wide, 1.0), 0.0, min(kit.between(1.95, 2.15), height - 0.1))
            doors.append(opening)
            openings.append(opening)
            if kit.chance(0.6):
                parts += moved(
                    door_leaf(kit, opening[1] - x, opening[3], float(kit.rng.choice([0.0, 60.0, 95.0, -20.0, -80.0]))),
                    x,
                    0,
                    thick * 0.5,
                )
        elif kit.chance(0.3):
            opening = (x, x + wide, kit.between(0.4, 1.1), height - kit.between(0.15, 0.5))
            openings.append(opening)
            parts += moved(window(kit, wide, opening[3] - opening[2]), x, opening[2], thick * 0.7)
            if kit.chance(0.4):
                for side in (0, 1):
                    curtain = hanging(kit, wide * kit.between(0.2, 0.7), opening[3] + 0.05 - kit.between(0.0, 0.8))
                    parts.append((curtain.moved(x + side * wide, opening[3] + 0.05, -0.1), kit.materials.cloth()))
        elif kit.chance(0.5):
            tall = kit.between(0.25, 1.1)
            middle = x + wide / 2, kit.between(1.0, height - tall / 2 - 0.1), -0.012
            parts.append(
                (box((wide * 0.7, tall, 0.024)).moved(*middle), kit.materials.one_of("wood", "black", "paint"))
            )
            parts.append(
                (box((wide * 0.7 - 0.05, tall - 0.05, 0.002)).moved(*middle[:2], -0.026), kit.materials.poster())
            )
        x += wide + kit.between(0.1, 1.5)
    parts.append((wall_with(width, height, thick, openings), paint))
    if kit.chance(0.5):
        skirting = [standing((b - a, 0.08, 0.02)).moved((a + b) / 2, 0, -0.01) for a, b in _between_doors(width, doors)]
        parts.append((joined(skirting), kit.materials.paint()))
    return parts, doors


def _between_doors(width: float, doors: list[Opening]) -> list[tuple[float, float]]:
    ends = [0.0, *(x for door in sorted(doors) for x in door[:2]), width]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > 0.02]


def window(kit: Kit, width: float, height: float) -> Parts:
    """Frame with bars before a bright or dark outside."""
    bars = [standing((0.05, height, 0.05)).moved(x) for x in np.linspace(0.025, width - 0.025, kit.number(2, 4))]
    bars += [standing((width, 0.05, 0.05)).moved(width / 2, y) for y in np.linspace(0, height - 0.05, kit.number(2, 4))]
    outside = box((width, height, 0.005)).moved(width / 2, height / 2, 0.05)
    sky = kit.materials.lamp(kit.between(0.5, 4)) if kit.chance(0.6) else kit.materials.black()
    return [(joined(bars), kit.materials.paint()), (outside, sky)]


def shell(kit: Kit, width: float, depth: float, height: float, paint: int) -> tuple[Parts, list[Parts]]:
    """Floor, ceiling and four walls of a room, x from -width / 2, z from 0; the room beyond each door comes with it."""
    parts: Parts = [(standing((width + 12, 0.1, depth + 12)).moved(0, -0.1, depth / 2), kit.materials.floor())]
    parts.append((standing((width + 12, 0.1, depth + 12)).moved(0, height, depth / 2), kit.materials.ceiling()))
    if kit.chance(0.15):
        slope = box((width + 2, 0.05, depth * 1.2)).turned(rotation(kit.between(25, 55) * kit.rng.choice([-1, 1]), "z"))
        parts.append((slope.moved(kit.rng.choice([-1, 1]) * width * 0.45, height * 0.85, depth / 2), paint))
    for turn, length, x, z in (
        (0, width, -width / 2, depth),
        (90, depth, width / 2, depth),
        (180, width, width / 2, 0),
        (270, depth, -width / 2, 0),
    ):
        wall, doors = one_wall(kit, length, height, paint if kit.chance(0.75) else kit.materials.wall())
        for left, right, _, _ in doors:
            away, wide = kit.between(0.8, 4), kit.between(0.4, 2)
            other = kit.materials.wall()
            back = standing((right - left + 2 * wide, height, 0.1)).moved((left + right) / 2, 0, away)
            sides = [standing((0.1, height, away)).moved(x_, 0, away / 2) for x_ in (left - wide, right + wide)]
            wall.append((joined([back, *sides]), other))
            if kit.chance(0.5):
                thing = kit.one_of(BY_WALL)(kit)
                wall += moved(thing, (left + right) / 2 + kit.rng.normal(0, 0.3), 0, away - 0.4)
        parts += moved(turned(wall, rotation(turn)), x, 0, z)
    return parts, []


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
    for _ in range(kit.number(0, 5)):
        parts += ground.put(turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360))))
    if kit.chance(0.5):
        parts += moved(rug(kit), kit.rng.normal(0, 0.5), 0.006, depth * kit.between(0.3, 0.7))
    for _ in range(kit.number(0, 6)):
        parts += ground.put(kit.one_of(SMALL)(kit))
    for _ in range(kit.rng.choice([0, 0, 1, 2])):
        parts += moved(hanging_lamp(kit), kit.between(-0.3, 0.3) * width, height, kit.between(0.3, 0.8) * depth)
    return parts


def rug(kit: Kit) -> Parts:
    size = kit.between(0.8, 2.5), 0.012, kit.between(0.8, 2.0)
    flat = box(size) if kit.chance(0.7) else lathe([(size[0] / 2, -0.006), (size[0] / 2, 0.006), (0, 0.006)], 40)
    return [(flat.turned(rotation(kit.rng.normal(0, 10))), kit.materials.rug())]


def hanging_lamp(kit: Kit) -> Parts:
    drop, radius = kit.between(0.2, 1.0), kit.between(0.06, 0.25)
    shade = (
        lathe([(radius, -drop), (radius * kit.between(0.2, 0.9), -drop + radius)], 26)
        if kit.chance(0.6)
        else ball((2 * radius,) * 3).moved(y=-drop)
    )
    return [
        (bar((0, 0, 0), (0, -drop + radius, 0), 0.004), kit.materials.black()),
        (shade, kit.materials.lamp(kit.between(1, 4))),
    ]


def room(kit: Kit) -> Setting:
    """A furnished room."""
    width, depth, height = kit.between(2.4, 6), kit.between(2.6, 7), kit.between(2.2, 3.2)
    parts, _ = shell(kit, width, depth, height, kit.materials.wall())
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
    parts, _ = shell(kit, width, depth, height, kit.materials.wall())
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


def backdrop(kit: Kit, low: float, high: float) -> Parts:
    """Floor, and a wall or two at some distance behind the origin, perhaps with furniture."""
    away, height = kit.between(low, high), kit.between(2.3, 3.2)
    paint = kit.materials.wall()
    parts: Parts = [(standing((16, 0.1, 16)).moved(0, -0.1, 0), kit.materials.floor())]
    wall, _ = one_wall(kit, 10, height, paint)
    wall = moved(wall, -5, 0, away)
    ends = [standing((14, height, 0.1)).moved(0, 0, z) for z in (-5, away + kit.between(0.8, 4))]
    ends += [standing((0.1, height, 18)).moved(x, 0, 0) for x in (-kit.between(1.5, 5), kit.between(1.5, 5))]
    wall.append((joined(ends), kit.materials.wall()))
    wall.append((standing((18, 0.1, 18)).moved(0, height, 0), kit.materials.ceiling()))
    if kit.chance(0.7):
        for _ in range(kit.number(1, 4)):
            thing = kit.one_of(BY_WALL)(kit)
            reach = extent(thing)[1][2]
            wall += moved(thing, kit.between(-3, 3), 0, away - reach - 0.02)
    return parts + turned(wall, rotation(kit.rng.normal(0, 20)))


def tabletop(kit: Kit) -> Setting:
    """A table full of things, seen from near."""
    width, depth, height = kit.between(0.8, 2.0), kit.between(0.6, 1.2), kit.between(0.4, 0.9)
    top = kit.materials.one_of("wood", "wood", "paint", "cloth", "anything", "black", "glaze", "rug")
    thick = kit.between(0.01, 0.08)
    parts: Parts = [(standing((width, thick, depth)).moved(0, height - thick, 0), top)]
    parts.append(
        (
            joined(
                [
                    standing((0.05, height - thick, 0.05)).moved(x * width * 0.46, 0, z * depth * 0.45)
                    for x in (-1, 1)
                    for z in (-1, 1)
                ]
            ),
            kit.materials.one_of("wood", "metal"),
        )
    )
    parts += laid_out(kit, width * 0.95, depth * 0.95, height, kit.number(4, 28), kit.one_of((SMALL, LOOSE, SMALL)))
    if kit.chance(0.6):
        parts += backdrop(kit, depth / 2 + 0.02, 0.8)
    else:
        parts += backdrop(kit, 0.8, 4)
    middle, reach = np.array([0, height, 0]), kit.between(0.5, 1.3)
    stand = middle + (-reach, 0.15 * reach, -reach), middle + (reach, 1.1 * reach, -0.3 * reach)
    return Setting(
        parts, stand, (middle - (width * 0.3, 0, depth * 0.3), middle + (width * 0.3, 0.15, depth * 0.4)), roll=5
    )


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
        parts += moved(
            open_box(
                width,
                depth,
                height,
                wall,
                kit.materials.one_of("plastic", "wood", "metal", "paint", "black", "pack", "anything"),
            ),
            y=raised,
        )
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
        x, z = (
            kit.between(-0.5, 0.5) * max(width - 1.6 * size, 0.02),
            kit.between(-0.5, 0.5) * max(depth - 1.6 * size, 0.02),
        )
        under = max(
            (top for a, b, r, top in heights if (a - x) ** 2 + (b - z) ** 2 < (0.7 * (r + size)) ** 2), default=wall
        )
        top = under + height_of(one)
        if top > height + 0.25:
            continue
        heights.append((x, z, size, under + 0.7 * (top - under)))
        parts += moved(one, x, raised + under, z)
    if kit.chance(0.3):
        parts += moved(backdrop(kit, 1.0, 3.0), 0, 0, 0)[1:]
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
        hung = turned(kit.one_of((LOOSE[11], LOOSE[12], LOOSE[13]))(kit), rotation(90, "x"))
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


def seating(kit: Kit) -> Setting:
    """Rows of one kind of chair or table, as in a meeting room, and people."""
    width, depth, height = kit.between(4, 8), kit.between(5, 9), kit.between(2.4, 3.5)
    parts, _ = shell(kit, width, depth, height, kit.materials.wall())
    thing, across, along, facing = (
        kit.one_of(FREE[:8]),
        kit.between(0.6, 1.6),
        kit.between(0.8, 1.8),
        kit.between(0, 360),
    )
    one = thing(kit)
    for x in np.arange(-width / 2 + 0.7, width / 2 - 0.6, across):
        for z in np.arange(1.5, depth - 0.8, along):
            if kit.chance(0.75):
                parts += moved(turned(one, rotation(facing + kit.rng.normal(0, 8))), x + kit.rng.normal(0, 0.05), 0, z)
    for _ in range(kit.number(0, 3)):
        parts += moved(
            turned(kit.one_of(FREE)(kit), rotation(kit.between(0, 360))),
            kit.between(-0.4, 0.4) * width,
            0,
            kit.between(0.4, 0.9) * depth,
        )
    stand = np.array([-width / 2 + 0.4, 0.8, 0.2]), np.array([width / 2 - 0.4, 2.2, 1.2])
    return Setting(parts, stand, (np.array([-width / 3, 0.3, depth * 0.4]), np.array([width / 3, 1.0, depth])))


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
        thing = kit.one_of((bush, tree, column, bush, tree, *FREE[9:12], *BY_WALL[13:16], table, *FREE[:3]))(kit)
        parts += ground.put(turned(thing, rotation(kit.between(0, 360))), 0.6)
    return Setting(
        parts,
        (np.array([-2, 0.8, -1.5]), np.array([2, 2.0, 0.5])),
        (np.array([-2.5, 0.2, 3]), np.array([2.5, 1.8, 8])),
        inside=False,
    )


def railing(kit: Kit, length: float, slope: float) -> Parts:
    """Rails along x that rise with a slope, on many thin posts."""
    high, pitch, thin = kit.between(0.8, 1.1), float(kit.rng.choice([0.1, 0.14, 1.0])), kit.between(0.005, 0.015)
    bars = [bar((x, slope * x, 0), (x, slope * x + high, 0), thin) for x in np.arange(0, length, pitch)]
    for y in (0.1, high) if pitch < 0.5 else (0.3, 0.55, high):
        bars.append(bar((0, y, 0), (length, slope * length + y, 0), 2 * thin))
    return [(joined(bars), kit.materials.one_of("metal", "paint", "black", "wood"))]


def column(kit: Kit) -> Parts:
    radius, height = kit.between(0.08, 0.4), kit.between(1, 4)
    shaft = (
        lathe([(radius, 0), (radius * 0.9, height), (0, height)], 26)
        if kit.chance(0.6)
        else standing((2 * radius, height, 2 * radius))
    )
    return [(shaft, kit.materials.one_of("street", "wall", "paint", "metal"))]


def bush(kit: Kit) -> Parts:
    size = kit.rng.uniform(0.4, 1.6, 3)
    core = lump(0.8 * size, 0.2, kit.rng).moved(y=size[1] * 0.4)
    return [
        (core, kit.materials.grass()),
        *leaves(kit, kit.number(60, 250), float(size.max()) * 0.7, 0.08, lift=(0.0, 1.6)),
    ]


def tree(kit: Kit) -> Parts:
    height, bark = kit.between(1.5, 4), kit.materials.wood()
    parts: Parts = [(bar((0, 0, 0), (kit.rng.normal(0, 0.1), height, 0), kit.between(0.05, 0.2), 0.03), bark)]
    for _ in range(kit.number(3, 9)):
        tip = kit.rng.normal(0, 0.6, 3) + (0, height, 0)
        parts.append((bar((0, height * kit.between(0.4, 0.9), 0), tip, 0.025, 0.008), bark))
        parts += moved(leaves(kit, kit.number(15, 60), 0.6, 0.1, lift=(-1.0, 1.6)), *tip)
    return parts


def stairwell(kit: Kit) -> Setting:
    """Steps indoors with walls, a landing and a railing."""
    wide, rise, tread, count = kit.between(0.8, 1.8), kit.between(0.15, 0.2), kit.between(0.24, 0.32), kit.number(6, 14)
    paint = kit.materials.wall()
    closed = kit.chance(0.6)
    boxes = [
        standing((wide, rise if not closed else rise * (n + 1), tread)).moved(
            0, 0 if closed else rise * n, n * tread + 1
        )
        for n in range(count)
    ]
    parts: Parts = [
        (joined(boxes), kit.materials.one_of("wood", "floor", "street")),
        (standing((14, 0.1, 20)).moved(0, -0.1, 5), kit.materials.floor()),
    ]
    end = count * tread + 1
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
    return Setting(
        parts,
        (np.array([-wide * 0.4, 0.7, -2.0]), np.array([wide * 0.9, 2.0, 0.0])),
        (np.array([-wide / 2, 0.3, 1.5]), np.array([wide / 2, rise * count, end])),
    )


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


LAYOUTS: tuple[tuple[Callable[[Kit], Setting], float], ...] = (
    (room, 0.27), (corridor, 0.07), (tabletop, 0.22), (picking, 0.12), (shelves, 0.08), (worktop, 0.06),
    (seating, 0.05), (outdoors, 0.05), (stairwell, 0.03), (jumble, 0.05),
)  # fmt: skip
