"""Things of thin bars, and hanging cloth."""

from __future__ import annotations

import numpy as np

from .parts import Kit, Parts, one_object
from .shapes import Shape, ball, bar, beam, box, joined, rotation, sheet, wire


@one_object
def ladder(kit: Kit) -> Parts:
    width, height = kit.between(0.3, 0.5), kit.between(1.2, 2.5)
    rails = [beam((s * width / 2, 0, 0), (s * width / 2, height, 0.4), 0.03, 0.06) for s in (-1, 1)]
    rungs = [
        bar((-width / 2, y, 0.4 * y / height), (width / 2, y, 0.4 * y / height), 0.014)
        for y in np.arange(0.25, height, 0.28)
    ]
    return [(joined(rails + rungs), kit.materials.one_of("metal", "wood", "paint"))]


@one_object
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


def hanging(kit: Kit, width: float, length: float) -> Shape:
    """Cloth that hangs in folds from height 0."""
    folds, deep = kit.between(2, 4) * max(width / 0.5, 1), kit.between(0.01, 0.06)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, int(12 * folds)), np.linspace(0, 1, 8))
    z = deep * np.sin(2 * np.pi * folds * x + kit.between(0, 6)) * (0.5 + 0.5 * y) + 0.5 * deep * np.sin(5 * x + 2 * y)
    return sheet(np.stack([x * width, -y * length, z], axis=-1))


@one_object
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


@one_object
def partition(kit: Kit) -> Parts:
    """Pane of glass in a thin frame, as of a glass door or a shower."""
    width, height = kit.between(0.7, 2.0), kit.between(0.9, 2.1)
    ends = [beam((x, 0, 0), (x, height, 0), 0.04, 0.04) for x in (-width / 2, width / 2)]
    ends += [beam((-width / 2, y, 0), (width / 2, y, 0), 0.04, 0.04) for y in (0.03, height)]
    pane = box((width, height, 0.01)).moved(y=height / 2)
    return [(joined(ends), kit.materials.one_of("metal", "black", "paint")), (pane, kit.materials.glass())]


@one_object
def easel(kit: Kit) -> Parts:
    """Board on thin legs."""
    legs = [bar((x, 0, z), (0, 1.7, 0.1), 0.015) for x, z in ((-0.35, -0.15), (0.35, -0.15), (0, 0.5))]
    board = box((kit.between(0.5, 1.0), kit.between(0.5, 0.9), 0.02)).turned(rotation(8, "x")).moved(0, 1.15, -0.03)
    return [(joined(legs), kit.materials.one_of("wood", "metal")), (board, kit.materials.poster())]
