"""Large things that stand on the floor about the origin; their front is towards -z."""

from __future__ import annotations

import numpy as np

from .parts import Ground, Kit, Parts, Thing, moved, set_down, turned
from .shapes import ball, bar, beam, box, joined, lathe, rotation, sheet, standing, wire
from .small_things import SMALL, bag, carton, fruit, leaves, monitor, open_box


def laid_out(kit: Kit, width: float, depth: float, y: float, count: int, things: tuple[Thing, ...] = SMALL) -> Parts:
    """Things on a horizontal rectangle about the origin."""
    ground, parts = Ground(kit, (-width / 2, width / 2), (-depth / 2, depth / 2), y), []
    for _ in range(count):
        parts += ground.put(turned(kit.one_of(things)(kit), rotation(kit.between(0, 360) if kit.chance(0.3) else 0)))
    return parts


def table(kit: Kit) -> Parts:
    width, depth = kit.between(0.5, 2.0), kit.between(0.4, 1.0)
    height, thick = (
        kit.rng.choice([kit.between(0.3, 0.5), kit.between(0.68, 0.8), kit.between(0.68, 0.8)]),
        kit.between(0.015, 0.06),
    )
    top_of, legs_of = (
        kit.materials.one_of("wood", "wood", "paint", "glaze", "black", "glass", "anything"),
        kit.materials.one_of("wood", "metal", "paint", "black"),
    )
    round_one = kit.chance(0.25)
    if round_one:
        radius = depth / 2 + 0.1
        top = lathe([(0, height - thick), (radius, height - thick), (radius, height), (0, height)], 40)
        width = depth = radius * 1.3
    else:
        top = standing((width, thick, depth)).moved(y=height - thick)
    if round_one and kit.chance(0.5):
        legs = [bar((0, 0, 0), (0, height - thick, 0), 0.04), lathe([(0, 0), (0.25, 0), (0.25, 0.02), (0, 0.03)], 30)]
    else:
        inset, thickness, splay = kit.between(0.02, 0.1), kit.between(0.015, 0.035), kit.between(0.7, 1.0)
        square = kit.chance(0.5)
        legs = []
        for x in (-1, 1):
            for z in (-1, 1):
                foot, head = (
                    (x * (width / 2 - inset), 0, z * (depth / 2 - inset)),
                    (x * (width / 2 - inset) * splay, height - thick, z * (depth / 2 - inset) * splay),
                )
                legs.append(beam(foot, head, 2 * thickness, 2 * thickness) if square else bar(foot, head, thickness))
        if kit.chance(0.4):
            legs.append(standing((width - 2 * inset, 0.08, depth - 2 * inset)).moved(y=height - thick - 0.08))
    parts: Parts = [(top, top_of), (joined(legs), legs_of)]
    if kit.chance(0.12):
        drop = kit.between(0.1, 0.4)
        parts.append(
            (standing((width * 1.01, drop, depth * 1.01)).moved(y=height - drop + 0.002), kit.materials.cloth())
        )
    return parts + laid_out(kit, width * 0.9, depth * 0.85, height + 0.002, kit.number(0, 12))


def desk(kit: Kit) -> Parts:
    width, depth, height = kit.between(1.0, 1.8), kit.between(0.5, 0.8), kit.between(0.7, 0.78)
    wood, other = kit.materials.one_of("wood", "paint", "black"), kit.materials.one_of("wood", "paint", "metal")
    parts: Parts = [(standing((width, 0.03, depth)).moved(y=height - 0.03), wood)]
    for side in (-1, 1):
        if kit.chance(0.5):
            parts.append((standing((0.03, height - 0.03, depth)).moved(x=side * (width / 2 - 0.02)), other))
        else:
            parts += moved(cupboard_of(kit, 0.4, height - 0.03, depth - 0.05), x=side * (width / 2 - 0.2))
    if kit.chance(0.7):
        parts += moved(monitor(kit), kit.between(-0.3, 0.3), height, depth * 0.2)
    return parts + laid_out(kit, width * 0.9, depth * 0.8, height, kit.number(2, 10))


def cupboard_of(kit: Kit, width: float, height: float, depth: float) -> Parts:
    """Closed box with doors or drawers and their knobs."""
    body, front = (
        kit.materials.one_of("wood", "paint", "paint", "metal", "anything"),
        kit.materials.one_of("wood", "paint", "paint", "black"),
    )
    columns, rows = max(1, round(width / kit.between(0.35, 0.7))), max(1, round(height / kit.between(0.2, 1.2)))
    gap, thick = kit.between(0.002, 0.012), kit.between(0.004, 0.02)
    doors, knobs = [], []
    for i in range(columns):
        for j in range(rows):
            x, y = (i + 0.5) * width / columns - width / 2, (j + 0.5) * height / rows
            doors.append(box((width / columns - gap, height / rows - gap, thick)).moved(x, y, -(depth + thick) / 2))
            knobs.append(box((kit.rng.choice([0.02, 0.12]), 0.015, 0.025)).moved(x, y, -depth / 2 - thick - 0.012))
    return [(standing((width, height, depth)), body), (joined(doors), front), (joined(knobs), kit.materials.metal())]


def cupboard(kit: Kit) -> Parts:
    width, height, depth = kit.between(0.4, 2.2), kit.between(0.4, 2.2), kit.between(0.3, 0.65)
    parts = cupboard_of(kit, width, height, depth)
    if height < 1.5:
        parts += laid_out(kit, width * 0.9, depth * 0.7, height, kit.number(0, 6))
    return parts


def shelf(kit: Kit) -> Parts:
    """Open boards full of things, with or without a back."""
    width, height, depth = kit.between(0.5, 2.0), kit.between(0.6, 2.2), kit.between(0.2, 0.4)
    return shelf_of(kit, width, height, depth)


def shelf_of(kit: Kit, width: float, height: float, depth: float) -> Parts:
    wood, thick = kit.materials.one_of("wood", "paint", "metal", "black"), kit.between(0.01, 0.035)
    boards = [standing((thick, height, depth)).moved(x=s * width / 2) for s in (-1, 1)]
    parts: Parts = []
    y, fullness = 0.04, kit.number(0, 9)
    while y < height - 0.1:
        boards.append(standing((width, thick, depth)).moved(y=y))
        room = kit.between(0.2, 0.45)
        on_it = laid_out(kit, width * 0.9, depth * 0.4, y + thick, fullness)
        parts += [(shape, m) for shape, m in on_it if shape.high[1] < y + room]
        y += room
    boards.append(standing((width, thick, depth)).moved(y=height))
    if kit.chance(0.6):
        parts.append(
            (standing((width, height, 0.008)).moved(z=depth / 2), kit.materials.one_of("wood", "paint", "wall"))
        )
    return [(joined(boards), wood), *parts]


def chair(kit: Kit) -> Parts:
    seat, width, depth = kit.between(0.4, 0.48), kit.between(0.36, 0.48), kit.between(0.36, 0.46)
    top, thick = seat + kit.between(0.3, 0.6), kit.between(0.009, 0.022)
    wood, cover = (
        kit.materials.one_of("wood", "metal", "paint", "black"),
        kit.materials.one_of("cloth", "wood", "plastic", "black"),
    )
    bars = []
    for x in (-1, 1):
        lean = kit.between(0.0, 0.08)
        bars.append(bar((x * width / 2, 0, -depth / 2), (x * width / 2 * 0.9, seat, -depth / 2 * 0.9), thick))
        bars.append(bar((x * width / 2, 0, depth / 2), (x * width / 2 * 0.95, seat, depth / 2 * 0.95), thick))
        bars.append(
            bar((x * width / 2 * 0.95, seat, depth / 2 * 0.95), (x * width / 2 * 0.95, top, depth / 2 + lean), thick)
        )
        if kit.chance(0.5):
            bars.append(
                bar((x * width * 0.46, seat * 0.5, -depth / 2), (x * width * 0.46, seat * 0.5, depth / 2), thick * 0.8)
            )
    style = kit.number(0, 3)
    if style == 0:
        backs = [box((width * 0.95, kit.between(0.1, top - seat), 0.015)).moved(0, top - 0.12, depth / 2 + 0.03)]
    elif style == 1:
        count = kit.number(3, 9)
        backs = [
            bar((x, seat, depth / 2 * 0.95), (x, top, depth / 2 + 0.04), thick * 0.6)
            for x in np.linspace(-0.42, 0.42, count) * width
        ]
        backs.append(bar((-width / 2, top, depth / 2 + 0.04), (width / 2, top, depth / 2 + 0.04), thick))
    elif style == 2:
        backs = [
            box((width * 0.95, 0.035, 0.012)).moved(0, y, depth / 2 + 0.03)
            for y in np.arange(seat + 0.1, top, kit.between(0.06, 0.14))
        ]
    else:
        x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(seat + 0.05, top, 6))
        backs = [sheet(np.stack([x * width / 2, y, depth / 2 - 0.02 + 0.06 * (1 - x**2) + 0.08 * (y - seat)], axis=-1))]
    cushion = ball((width * 1.05, 0.06, depth * 1.05), 0.3) if kit.chance(0.5) else box((width, 0.025, depth))
    return [
        (joined(bars), wood),
        (joined(backs), kit.materials.one_of("wood", "plastic", "cloth") if style in (0, 3) else wood),
        (cushion.moved(y=seat), cover),
    ]


def office_chair(kit: Kit) -> Parts:
    black, cloth = kit.materials.one_of("black", "metal", "plastic"), kit.materials.one_of("cloth", "black", "paint")
    spokes = [bar((0, 0.1, 0), (0.3 * np.cos(a), 0.05, 0.3 * np.sin(a)), 0.02) for a in np.arange(5) * 2 * np.pi / 5]
    wheels = [
        ball((0.05, 0.06, 0.05)).moved(0.3 * np.cos(a), 0.03, 0.3 * np.sin(a)) for a in np.arange(5) * 2 * np.pi / 5
    ]
    seat = kit.between(0.42, 0.55)
    parts: Parts = [
        (
            joined(
                [
                    *spokes,
                    *wheels,
                    bar((0, 0.08, 0), (0, seat, 0), 0.025),
                    beam((0, seat, 0.2), (0, seat + 0.3, 0.27), 0.06, 0.02),
                ]
            ),
            black,
        )
    ]
    back = ball((0.44, kit.between(0.4, 0.7), 0.08), 0.35).moved(0, seat + 0.4, 0.26)
    return [*parts, (ball((0.48, 0.09, 0.46), 0.35).moved(y=seat), cloth), (back, cloth)]


def stool(kit: Kit) -> Parts:
    height, radius = kit.between(0.4, 0.8), kit.between(0.14, 0.22)
    legs = [
        bar(
            (radius * np.cos(a), 0, radius * np.sin(a)),
            (radius * 0.5 * np.cos(a), height, radius * 0.5 * np.sin(a)),
            0.014,
        )
        for a in np.arange(3 + kit.number(0, 1)) * 1.9
    ]
    return [
        (joined(legs), kit.materials.one_of("wood", "metal")),
        (
            lathe([(0, height), (radius, height), (radius, height + 0.04), (0, height + 0.05)]),
            kit.materials.one_of("wood", "cloth", "paint"),
        ),
    ]


def cushion(kit: Kit) -> Parts:
    size = kit.between(0.3, 0.5)
    return [(ball((size, size, kit.between(0.1, 0.2)), 0.55), kit.materials.cloth())]


def sofa(kit: Kit) -> Parts:
    seats, each, depth = kit.number(1, 3), kit.between(0.55, 0.75), kit.between(0.75, 1.0)
    length, cloth, round_ = seats * each + 0.4, kit.materials.cloth(), kit.between(0.12, 0.4)
    body = [
        ball((length, 0.28, depth), round_ * 0.5).moved(y=0.22),
        ball((length, kit.between(0.45, 0.7), 0.24), round_).moved(0, 0.55, depth / 2 - 0.12),
    ]
    body += [ball((0.2, kit.between(0.4, 0.5), depth), round_).moved(s * (length / 2 - 0.1), 0.4, 0) for s in (-1, 1)]
    rows = [
        ball((each, 0.18, depth - 0.2), round_).moved((i - (seats - 1) / 2) * each, 0.42, -0.08) for i in range(seats)
    ]
    parts: Parts = [(joined(body), cloth), (joined(rows), cloth if kit.chance(0.7) else kit.materials.cloth())]
    for _ in range(kit.number(0, 4)):
        pillow = turned(cushion(kit), rotation(kit.rng.normal(0, 15), "z") @ rotation(-kit.between(10, 35), "x"))
        parts += moved(pillow, kit.between(-0.4, 0.4) * length, 0.68, depth * 0.15)
    if kit.chance(0.25):
        parts.append(
            (draped(kit, length * 0.4, depth).moved(kit.between(-0.2, 0.2) * length, 0.53, -0.1), kit.materials.cloth())
        )
    return parts


def draped(kit: Kit, width: float, depth: float, fold: float = 0.03) -> object:
    """Blanket with soft folds, lying."""
    x, z = np.meshgrid(np.linspace(-1, 1, 30), np.linspace(-1, 1, 30))
    y = sum(
        fold
        / (n + 1)
        * np.sin(kit.between(1, 5) * (n + 1) * x + kit.rng.normal(0, 2) * (n + 1) * z + kit.between(0, 6))
        for n in range(4)
    )
    return sheet(
        np.stack(
            [
                x * width / 2,
                y - 0.5 * np.maximum(np.abs(x) - 0.8, 0) - 0.8 * np.maximum(np.abs(z) - 0.8, 0),
                z * depth / 2,
            ],
            axis=-1,
        )
    )


def bed(kit: Kit) -> Parts:
    width, length, height = kit.between(0.8, 1.8), kit.between(1.9, 2.1), kit.between(0.3, 0.55)
    wood, cloth = kit.materials.one_of("wood", "paint", "cloth"), kit.materials.cloth()
    parts: Parts = [
        (standing((width, height * 0.6, length)), wood),
        (ball((width, 0.24, length), 0.2).moved(y=height * 0.6 + 0.1), kit.materials.cloth()),
    ]
    parts.append((draped(kit, width * 1.15, length * 0.7, 0.04).moved(0, height * 0.6 + 0.26, -length * 0.15), cloth))
    for x in (-0.25, 0.25) if width > 1.2 else (0,):
        pillow = (
            ball((0.6, 0.16, 0.4), 0.5)
            .turned(rotation(-kit.between(0, 50), "x"))
            .moved(x * width, height * 0.6 + 0.32, length / 2 - 0.25)
        )
        parts.append((pillow, kit.materials.cloth()))
    if kit.chance(0.7):
        parts.append((standing((width, kit.between(0.8, 1.2), 0.06)).moved(z=length / 2), wood))
    return parts


def floor_lamp(kit: Kit) -> Parts:
    height, radius = kit.between(1.2, 1.8), kit.between(0.1, 0.25)
    stand = [lathe([(0, 0), (0.14, 0), (0.14, 0.02), (0, 0.03)]), bar((0, 0.02, 0), (0, height, 0), 0.012)]
    shade = lathe([(radius, height - radius), (radius * kit.between(0.4, 1), height + 0.05)], 30)
    return [
        (joined(stand), kit.materials.one_of("metal", "black", "wood")),
        (shade, kit.materials.lamp(kit.between(1, 4))),
    ]


def big_plant(kit: Kit) -> Parts:
    radius, height = kit.between(0.12, 0.25), kit.between(0.2, 0.5)
    pot = lathe(
        [
            (0, 0),
            (radius * 0.8, 0),
            (radius, height),
            (radius * 0.9, height),
            (radius * 0.85, height * 0.9),
            (0, height * 0.9),
        ],
        30,
    )
    parts: Parts = [(pot, kit.materials.one_of("glaze", "plastic", "wood", "anything"))]
    stem = kit.between(0.0, 1.0)
    if stem > 0.3:
        for _ in range(kit.number(1, 4)):
            tip = (kit.rng.normal(0, 0.15), height + stem, kit.rng.normal(0, 0.15))
            parts.append((bar((0, height * 0.8, 0), tip, 0.012, 0.006), kit.materials.wood()))
            parts += moved(leaves(kit, kit.number(8, 30), 0.45, kit.between(0.03, 0.18), lift=(-0.5, 1.5)), *tip)
        return parts
    length = kit.between(0.4, 1.0)
    return parts + moved(
        leaves(kit, kit.number(12, 60), length, length * kit.between(0.04, 0.3), lift=(0.4, 1.6)), y=height * 0.9
    )


def bin_(kit: Kit) -> Parts:
    radius, height = kit.between(0.1, 0.2), kit.between(0.2, 0.5)
    shell = lathe(
        [(0, 0.005), (radius * 0.8, 0), (radius, height), (radius - 0.006, height), (radius * 0.79, 0.01), (0, 0.01)],
        26,
    )
    return [
        (shell, kit.materials.one_of("plastic", "metal", "black", "paint")),
        *moved(set_down(bag(kit)), y=height * 0.4),
    ]


def box_pile(kit: Kit) -> Parts:
    """Removal boxes and crates, one on another."""
    parts: Parts = []
    for x in range(kit.number(1, 3)):
        y = 0.0
        for _ in range(kit.number(1, 4)):
            size = kit.rng.uniform(0.2, 0.6, 3)
            parts.append(
                (
                    standing(size)
                    .turned(rotation(kit.rng.normal(0, 12)))
                    .moved(x * 0.5 + kit.rng.normal(0, 0.04), y, kit.rng.normal(0, 0.04)),
                    kit.materials.one_of("pack", "wood", "paint"),
                )
            )
            y += size[1]
    return parts


def person(kit: Kit) -> Parts:
    """Figure of rounded limbs that stands, sits or reaches out."""
    tall, cloth, legs_of, skin = (
        kit.between(1.5, 1.9),
        kit.materials.cloth(),
        kit.materials.one_of("cloth", "black"),
        kit.materials.skin(),
    )
    hip, neck, wide = 0.5 * tall, 0.82 * tall, kit.between(0.17, 0.24)
    sits = kit.chance(0.3)
    parts: Parts = [
        (ball((2 * wide, neck - hip + 0.12, 0.24), 0.6).moved(0, (hip + neck) / 2, 0), cloth),
        (ball((0.16, 0.23, 0.2)).moved(0, 0.93 * tall, 0), skin),
    ]
    parts.append((ball((0.175, 0.15, 0.215)).moved(0, 0.965 * tall, 0.015), kit.materials.one_of("black", "paint")))
    parts.append((bar((0, neck - 0.02, 0), (0, neck + 0.08, 0), 0.05), skin))
    for s in (-1, 1):
        forward = kit.between(-0.1, 0.15)
        knee = np.array([s * 0.11, hip, -0.42]) if sits else np.array([s * 0.11, hip * 0.52, -forward])
        foot = knee + (0, 0.06 - knee[1] if not sits else -0.42, 0.05)
        parts.append((joined([capsule((s * 0.1, hip, 0), knee, 0.085), capsule(knee, foot, 0.065)]), legs_of))
        parts.append((ball((0.1, 0.09, 0.27), 0.7).moved(*(foot + (0, 0, -0.06))), kit.materials.black()))
        shoulder = np.array([s * wide, neck - 0.06, 0])
        elbow = shoulder + kit.rng.normal((s * 0.1, -0.25, -0.05), 0.07)
        hand = elbow + kit.rng.normal((0, -0.1, -0.15), 0.12)
        parts.append((joined([capsule(shoulder, elbow, 0.055), capsule(elbow, hand, 0.045)]), cloth))
        parts.append((ball((0.09, 0.1, 0.1)).moved(*hand), skin))
    return set_down(parts) if not sits else moved(parts, y=0.42 - hip + 0.06)


def capsule(start: object, end: object, radius: float) -> object:
    """Limb with round ends."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    ends = [ball((2 * radius,) * 3, rows=8, columns=12).moved(*at) for at in (start, end)]
    return joined([bar(start, end, radius), *ends])


def ladder(kit: Kit) -> Parts:
    width, height = kit.between(0.3, 0.5), kit.between(1.2, 2.5)
    rails = [beam((s * width / 2, 0, 0), (s * width / 2, height, 0.4), 0.03, 0.06) for s in (-1, 1)]
    rungs = [
        bar((-width / 2, y, 0.4 * y / height), (width / 2, y, 0.4 * y / height), 0.014)
        for y in np.arange(0.25, height, 0.28)
    ]
    return [(joined(rails + rungs), kit.materials.one_of("metal", "wood", "paint"))]


def rack(kit: Kit) -> Parts:
    """Coat stand or drying rack with cloth on it."""
    height = kit.between(1.0, 1.8)
    frame = [bar((s * 0.4, 0, 0), (s * 0.4, height, 0), 0.012) for s in (-1, 1)] + [
        bar((-0.4, height, 0), (0.4, height, 0), 0.012)
    ]
    frame += [bar((s * 0.4, 0.02, -0.25), (s * 0.4, 0.02, 0.25), 0.012) for s in (-1, 1)]
    parts: Parts = [(joined(frame), kit.materials.one_of("metal", "black"))]
    for _ in range(kit.number(1, 5)):
        parts.append(
            (
                hanging(kit, kit.between(0.2, 0.5), kit.between(0.3, 0.9)).moved(
                    kit.between(-0.3, 0.3), height, kit.rng.normal(0, 0.06)
                ),
                kit.materials.cloth(),
            )
        )
    return parts


def hanging(kit: Kit, width: float, length: float) -> object:
    """Cloth that hangs in folds from height 0."""
    folds, deep = kit.between(2, 4) * max(width / 0.5, 1), kit.between(0.01, 0.06)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, int(12 * folds)), np.linspace(0, 1, 8))
    z = deep * np.sin(2 * np.pi * folds * x + kit.between(0, 6)) * (0.5 + 0.5 * y) + 0.5 * deep * np.sin(5 * x + 2 * y)
    return sheet(np.stack([x * width, -y * length, z], axis=-1))


def bicycle(kit: Kit) -> Parts:
    angle, wheels = np.linspace(0, 2 * np.pi, 40), []
    for x in (-0.5, 0.5):
        wheels.append(
            wire(np.stack([x + 0.33 * np.cos(angle), 0.35 + 0.33 * np.sin(angle), 0 * angle], axis=-1), 0.018)
        )
        wheels += [
            bar((x, 0.35, 0), (x + 0.32 * np.cos(a), 0.35 + 0.32 * np.sin(a), 0), 0.002)
            for a in np.arange(12) * np.pi / 6
        ]
    joints = {
        "back": (-0.5, 0.35, 0),
        "crank": (-0.08, 0.3, 0),
        "seat": (-0.2, 0.8, 0),
        "head": (0.33, 0.8, 0),
        "front": (0.5, 0.35, 0),
    }
    tubes = [
        bar(joints[a], joints[b], 0.016)
        for a, b in (
            ("back", "crank"),
            ("crank", "seat"),
            ("seat", "head"),
            ("crank", "head"),
            ("head", "front"),
            ("back", "seat"),
        )
    ]
    tubes += [
        bar((0.3, 0.95, -0.25), (0.3, 0.95, 0.25), 0.012),
        bar((0.33, 0.8, 0), (0.3, 0.95, 0), 0.014),
        ball((0.25, 0.06, 0.14)).moved(-0.2, 0.87, 0),
    ]
    return [(joined(wheels), kit.materials.black()), (joined(tubes), kit.materials.paint())]


def easel(kit: Kit) -> Parts:
    """Board on thin legs."""
    legs = [bar((x, 0, z), (0, 1.7, 0.1), 0.015) for x, z in ((-0.35, -0.15), (0.35, -0.15), (0, 0.5))]
    board = box((kit.between(0.5, 1.0), kit.between(0.5, 0.9), 0.02)).turned(rotation(8, "x")).moved(0, 1.15, -0.03)
    return [(joined(legs), kit.materials.one_of("wood", "metal")), (board, kit.materials.poster())]


def tub(kit: Kit) -> Parts:
    """Open crate on the floor with things in it."""
    width, depth, height = kit.between(0.3, 0.7), kit.between(0.3, 0.6), kit.between(0.2, 0.5)
    parts = open_box(width, depth, height, 0.012, kit.materials.one_of("plastic", "wood", "metal", "paint"))
    return parts + laid_out(kit, width * 0.5, depth * 0.5, 0.02, kit.number(1, 6), (carton, bag, fruit))


BY_WALL = (
    cupboard,
    cupboard,
    cupboard,
    shelf,
    shelf,
    shelf,
    sofa,
    sofa,
    bed,
    desk,
    desk,
    table,
    big_plant,
    floor_lamp,
    box_pile,
    bicycle,
    rack,
    ladder,
    chair,
    person,
    tub,
)
"""What stands with its back to a wall."""
FREE = (
    table,
    table,
    chair,
    chair,
    chair,
    chair,
    office_chair,
    office_chair,
    stool,
    person,
    person,
    big_plant,
    floor_lamp,
    box_pile,
    bin_,
    tub,
    rack,
    easel,
    sofa,
)
"""What stands anywhere."""
