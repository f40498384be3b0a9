"""What stands on desks: keyboards, screens, lamps."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, moved, one_object, turned
from .shapes import bar, beam, box, joined, lathe, rotation, standing, wire


@one_object
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


@one_object
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


@one_object
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


@one_object
def table_lamp(kit: Kit) -> Parts:
    height, radius = kit.between(0.25, 0.6), kit.between(0.08, 0.2)
    foot = lathe([(0, 0), (0.08, 0), (0.08, 0.015), (0.015, 0.03), (0.012, height), (0, height)])
    shade = lathe([(radius, height * 0.65), (radius * kit.between(0.3, 1), height * 1.1)], 26)
    return [(foot, kit.materials.one_of("metal", "wood", "glaze")), (shade, kit.materials.lamp(kit.between(0.8, 3)))]


@one_object
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


@one_object
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
