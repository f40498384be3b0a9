"""Things that stand on tables and shelves, each about the origin with its lowest point at height 0."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, extent, height_of, moved, set_down, turned
from .shapes import (
    any_rotation,
    ball,
    bar,
    beam,
    box,
    joined,
    lathe,
    lump,
    prism,
    rotation,
    sheet,
    sheets,
    standing,
    wire,
)


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


def can(kit: Kit) -> Parts:
    radius, height = kit.between(0.025, 0.06), kit.between(0.04, 0.18)
    tin = lathe(
        [(0, height - 0.003), (radius * 0.93, height - 0.003), (radius * 0.95, height), (radius, height - 0.004)]
    )
    side = lathe([(radius, height - 0.004), (radius, 0), (0, 0)])
    return [(tin, kit.materials.metal()), (side, kit.materials.one_of("pack", "metal", "plastic", "glaze"))]


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


def book(kit: Kit, upright: bool = False) -> Parts:
    height, width, thick = kit.between(0.12, 0.3), kit.between(0.09, 0.22), kit.between(0.008, 0.05)
    cover, pages = kit.materials.pack(), kit.materials.paper()
    parts: Parts = [
        (
            joined(
                [box((0.003, height, width)).moved(x=s * thick / 2) for s in (-1, 1)]
                + [box((thick, height, 0.003)).moved(z=-width / 2)]
            ),
            cover,
        ),
        (box((thick - 0.002, height - 0.008, width - 0.006)), pages),
    ]
    return set_down(parts if upright else turned(parts, rotation(90, "z")))


def books(kit: Kit) -> Parts:
    """A pile, or a row that leans."""
    parts: Parts = []
    if kit.chance(0.5):
        y = 0.0
        for _ in range(kit.number(1, 7)):
            one = turned(book(kit), rotation(kit.rng.normal(0, 20)))
            parts += moved(one, y=y)
            y += height_of(one)
        return parts
    x = 0.0
    for _ in range(kit.number(2, 9)):
        one = book(kit, upright=True)
        width = extent(one)[1][0]
        parts += moved(turned(one, rotation(kit.between(-8, 0) if kit.chance(0.2) else 0, "z")), x + width)
        x += 2 * width + 0.002
    return set_down(parts)


def open_book(kit: Kit) -> Parts:
    width, height = kit.between(0.08, 0.16), kit.between(0.15, 0.28)
    paper = kit.materials.paper()
    x = np.linspace(0, 1, 8)
    rise = kit.between(0.01, 0.04) * np.sqrt(x) * (1.6 - x) + 0.002
    halves = []
    for side in (-1, 1):
        line = np.stack([side * width * x, rise, 0 * x], axis=-1)
        halves.append(sheet(np.stack([line - (0, 0, height / 2), line + (0, 0, height / 2)])))
    return [(half, paper) for half in halves]


def papers(kit: Kit) -> Parts:
    parts: Parts = []
    for n in range(kit.number(1, 5)):
        leaf = (
            box((0.21, 0.0008, 0.297))
            .turned(rotation(kit.between(0, 360)))
            .moved(kit.rng.normal(0, 0.05), 0.0005 + 0.001 * n, kit.rng.normal(0, 0.05))
        )
        parts.append((leaf, kit.materials.paper()))
    return parts


def fruit(kit: Kit) -> Parts:
    size = np.array([1, kit.between(0.7, 1.4), 1]) * kit.between(0.04, 0.12)
    parts: Parts = [(ball(size).moved(y=size[1] / 2), kit.materials.one_of("paint", "anything", "plastic"))]
    if kit.chance(0.5):
        parts.append((bar((0, size[1] * 0.97, 0), (0.006, size[1] + 0.015, 0), 0.002), kit.materials.wood()))
    return parts


def brick(kit: Kit) -> Parts:
    """Rounded block: soap, a sponge, a toy, a mouse."""
    size = kit.rng.uniform(0.03, 0.16, 3) * (1, 0.6, 1)
    body = ball(size, kit.between(0.15, 0.7)).moved(y=size[1] / 2)
    return [(body, kit.materials.one_of("paint", "plastic", "cloth", "black", "anything"))]


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


def pliers(kit: Kit) -> Parts:
    """Scissors or tongs: two bent arms that cross."""
    arms, t = [], np.linspace(-1, 1, 14)
    spread, length = kit.between(0.01, 0.05), kit.between(0.06, 0.14)
    for side in (-1, 1):
        across = side * spread * np.sin(t * 2.4) * np.where(t < 0, 1, 0.5)
        arms.append(wire(np.stack([length * t, 0.008 + 0 * t, across], axis=-1), kit.between(0.003, 0.008)))
    return turned([(arm, kit.materials.one_of("plastic", "metal")) for arm in arms], rotation(kit.between(0, 360)))


def cable(kit: Kit) -> Parts:
    t = np.linspace(0, 1, 60)
    reach, waves = kit.between(0.1, 0.5), kit.rng.normal(0, 1, (2, 2, 3))
    path = np.zeros((len(t), 3))
    for n in range(3):
        path[:, 0] += waves[0, 0, n] * np.sin((n + 1) * np.pi * t) + waves[0, 1, n] * np.cos((n + 1) * np.pi * t)
        path[:, 2] += waves[1, 0, n] * np.sin((n + 1) * np.pi * t) + waves[1, 1, n] * np.cos((n + 1) * np.pi * t)
    path *= reach / 2
    thick = kit.between(0.0015, 0.006)
    path[:, 1] = thick
    return [(wire(path, thick), kit.materials.one_of("black", "paint", "plastic"))]


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


def keyboard(kit: Kit) -> Parts:
    rows, columns = kit.number(4, 6), kit.number(10, 16)
    keys = [
        box((0.015, 0.008, 0.015)).moved((i - columns / 2) * 0.019, 0.016, (j - rows / 2) * 0.019)
        for i in range(columns)
        for j in range(rows)
    ]
    case = standing((columns * 0.019 + 0.02, 0.014, rows * 0.019 + 0.02)).moved(-0.0095, 0, -0.0095)
    return turned(
        [(case, kit.materials.one_of("plastic", "black")), (joined(keys), kit.materials.one_of("plastic", "black"))],
        rotation(kit.rng.normal(0, 10)),
    )


def monitor(kit: Kit) -> Parts:
    width = kit.between(0.3, 0.8)
    height, foot = width * kit.between(0.5, 0.75), kit.between(0.05, 0.2)
    shell = kit.materials.one_of("black", "plastic", "paint")
    return turned([
        (box((width, height, 0.03)).moved(y=foot + height / 2), shell),
        (box((width - 0.03, height - 0.03, 0.002)).moved(y=foot + height / 2, z=-0.0155), kit.materials.screen()),
        (beam((0, 0, 0.03), (0, foot + height / 2, 0.03), 0.05, 0.02), shell),
        (standing((width * 0.4, 0.012, 0.18)), shell),
    ], rotation(kit.rng.normal(0, 20)))  # fmt: skip


def laptop(kit: Kit) -> Parts:
    shell, width, depth = (
        kit.materials.one_of("metal", "black", "plastic", "paint"),
        kit.between(0.26, 0.38),
        kit.between(0.19, 0.26),
    )
    keys = [
        box((0.014, 0.002, 0.014)).moved((i - 6) * 0.018, 0.02, (j - 1) * 0.018) for i in range(13) for j in range(4)
    ]
    lid = [
        (box((width, 0.008, depth)), shell),
        (box((width - 0.02, 0.001, depth - 0.02)).moved(y=0.0045), kit.materials.screen()),
    ]
    lid = turned(moved(lid, z=depth / 2), rotation(-kit.between(60, 85), "x"))
    return turned(
        [
            (standing((width, 0.018, depth)), shell),
            (joined(keys), kit.materials.black()),
            *moved(lid, y=0.018, z=depth / 2),
        ],
        rotation(kit.rng.normal(0, 25)),
    )


def table_lamp(kit: Kit) -> Parts:
    height, radius = kit.between(0.25, 0.6), kit.between(0.08, 0.2)
    foot = lathe([(0, 0), (0.08, 0), (0.08, 0.015), (0.015, 0.03), (0.012, height), (0, height)])
    shade = lathe([(radius, height * 0.65), (radius * kit.between(0.3, 1), height * 1.1)], 26)
    return [(foot, kit.materials.one_of("metal", "wood", "glaze")), (shade, kit.materials.lamp(kit.between(0.8, 3)))]


def desk_lamp(kit: Kit) -> Parts:
    elbow, head = (
        np.array([kit.between(-0.2, 0.2), kit.between(0.25, 0.4), 0.1]),
        np.array([kit.between(-0.2, 0.2), kit.between(0.35, 0.6), -0.15]),
    )
    steel = kit.materials.one_of("metal", "paint", "black")
    hood = (
        lathe([(0.02, 0), (0.08, -0.12), (0.078, -0.12), (0.0, -0.005)])
        .turned(rotation(kit.between(-40, 40), "x"))
        .moved(*head)
    )
    return [
        (
            joined(
                [
                    lathe([(0, 0), (0.09, 0), (0.09, 0.02), (0, 0.02)]),
                    bar((0, 0.02, 0.05), elbow, 0.007),
                    bar(elbow, head, 0.007),
                ]
            ),
            steel,
        ),
        (hood, steel),
    ]


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


def bag(kit: Kit) -> Parts:
    size = kit.rng.uniform(0.08, 0.3, 3)
    return set_down(
        [(lump(size, kit.between(0.05, 0.25), kit.rng), kit.materials.one_of("cloth", "pack", "black", "paint"))]
    )


def polygon(kit: Kit) -> Parts:
    """Prism, gear-like slab or wedge with a random outline."""
    angle = np.sort(kit.rng.uniform(0, 2 * np.pi, kit.number(3, 8)))
    outline = np.stack([np.cos(angle), np.sin(angle)], axis=1) * kit.rng.uniform(0.03, 0.1, 2)
    return [(prism(outline, kit.between(0.01, 0.2)), kit.materials.one_of("paint", "plastic", "pack", "metal", "wood"))]


def ring(kit: Kit) -> Parts:
    """Roll of tape, a ring or a wheel, standing or lying."""
    radius, thick = kit.between(0.03, 0.1), kit.between(0.01, 0.06)
    hole = radius * kit.between(0.3, 0.85)
    body = lathe([(hole, 0), (radius, 0), (radius, thick), (hole, thick), (hole, 0)], 26)
    parts: Parts = [(body, kit.materials.one_of("plastic", "paint", "metal", "black", "pack"))]
    return set_down(turned(parts, rotation(90, "x") @ rotation(kit.between(0, 90)))) if kit.chance(0.3) else parts


def frame(kit: Kit) -> Parts:
    """Picture frame that leans."""
    width, height = kit.between(0.1, 0.3), kit.between(0.1, 0.35)
    parts: Parts = [
        (box((width, height, 0.015)), kit.materials.one_of("wood", "paint", "metal")),
        (box((width - 0.03, height - 0.03, 0.001)).moved(z=-0.0085), kit.materials.poster()),
    ]
    return set_down(turned(parts, rotation(kit.rng.normal(0, 25)) @ rotation(kit.between(5, 20), "x")))


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


def open_box(width: float, depth: float, height: float, wall: float, material: int) -> Parts:
    floor = standing((width, wall, depth))
    sides = [standing((wall, height, depth)).moved(x=s * (width - wall) / 2) for s in (-1, 1)]
    ends = [standing((width - 2 * wall, height, wall)).moved(z=s * (depth - wall) / 2) for s in (-1, 1)]
    return [(joined([floor, *sides, *ends]), material)]


SMALL = (
    carton, carton, carton, bottle, bottle, can, can, vessel, vessel, vessel, vessel, book, books, books, open_book, papers,
    fruit, brick, brick, tool, tool, pliers, cable, holder, keyboard, monitor, laptop, table_lamp, desk_lamp, flowers,
    potted, potted, bag, polygon, ring, frame, basket,
)  # fmt: skip
LOOSE = (
    carton,
    carton,
    carton,
    bottle,
    can,
    can,
    vessel,
    book,
    fruit,
    brick,
    brick,
    tool,
    tool,
    pliers,
    bag,
    polygon,
    ring,
)
"""Things that may lie in any position."""
