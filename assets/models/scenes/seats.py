"""What one sits and lies on; about the origin, front towards -z."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, moved, one_object, turned
from .shapes import Shape, ball, bar, beam, box, joined, lathe, rotation, sheet, standing


@one_object
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


@one_object
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


@one_object
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


@one_object
def cushion(kit: Kit) -> Parts:
    size = kit.between(0.3, 0.5)
    return [(ball((size, size, kit.between(0.1, 0.2)), 0.55), kit.materials.cloth())]


@one_object
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


def draped(kit: Kit, width: float, depth: float, fold: float = 0.03) -> Shape:
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


@one_object
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
