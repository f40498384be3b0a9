"""People, plants and lamps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .containers import leaves
from .parts import Kit, Parts, moved, one_object, set_down
from .shapes import Shape, ball, bar, joined, lathe


@one_object
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
        foot = np.add(knee, (0, 0.06 - knee[1] if not sits else -0.42, 0.05))
        parts.append((joined([capsule((s * 0.1, hip, 0), knee, 0.085), capsule(knee, foot, 0.065)]), legs_of))
        parts.append((ball((0.1, 0.09, 0.27), 0.7).moved(*np.add(foot, (0, 0, -0.06))), kit.materials.black()))
        shoulder = np.array([s * wide, neck - 0.06, 0])
        elbow = shoulder + kit.rng.normal((s * 0.1, -0.25, -0.05), 0.07)
        hand = elbow + kit.rng.normal((0, -0.1, -0.15), 0.12)
        parts.append((joined([capsule(shoulder, elbow, 0.055), capsule(elbow, hand, 0.045)]), cloth))
        parts.append((ball((0.09, 0.1, 0.1)).moved(*hand), skin))
    return set_down(parts) if not sits else moved(parts, y=0.42 - hip + 0.06)


def capsule(start: Sequence[float], end: Sequence[float], radius: float) -> Shape:
    """Limb with round ends."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    ends = [ball((2 * radius,) * 3, rows=8, columns=12).moved(*at) for at in (start, end)]
    return joined([bar(start, end, radius), *ends])


@one_object
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


@one_object
def floor_lamp(kit: Kit) -> Parts:
    height, radius = kit.between(1.2, 1.8), kit.between(0.1, 0.25)
    stand = [lathe([(0, 0), (0.14, 0), (0.14, 0.02), (0, 0.03)]), bar((0, 0.02, 0), (0, height, 0), 0.012)]
    shade = lathe([(radius, height - radius), (radius * kit.between(0.4, 1), height + 0.05)], 30)
    return [
        (joined(stand), kit.materials.one_of("metal", "black", "wood")),
        (shade, kit.materials.lamp(kit.between(1, 4))),
    ]
