"""Books, papers, pictures."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, extent, height_of, moved, one_object, set_down, turned
from .shapes import box, joined, rotation, sheet


@one_object
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


@one_object
def open_book(kit: Kit) -> Parts:
    width, height = kit.between(0.08, 0.16), kit.between(0.15, 0.28)
    paper = kit.materials.paper()
    x = np.linspace(0, 1, 8)
    rise = kit.between(0.01, 0.04) * np.sqrt(x) * (1.6 - x) + 0.002
    halves = []
    for side in (-1, 1):
        line = np.stack([side * width * x, rise, 0 * x], axis=-1)
        halves.append(sheet(np.stack([np.add(line, (0, 0, z)) for z in (-height / 2, height / 2)])))
    return [(half, paper) for half in halves]


@one_object
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


@one_object
def frame(kit: Kit) -> Parts:
    """Picture frame that leans."""
    width, height = kit.between(0.1, 0.3), kit.between(0.1, 0.35)
    parts: Parts = [
        (box((width, height, 0.015)), kit.materials.one_of("wood", "paint", "metal")),
        (box((width - 0.03, height - 0.03, 0.001)).moved(z=-0.0085), kit.materials.poster()),
    ]
    return set_down(turned(parts, rotation(kit.rng.normal(0, 25)) @ rotation(kit.between(5, 20), "x")))
