"""Pieces of a scene: shapes with their materials, and how to set them down."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .materials import Materials
from .shapes import Shape

Parts = list[tuple[Shape, int]]
"""Shapes and the numbers of their materials."""


@dataclass(frozen=True)
class Kit:
    """What things are made with: chance, and the scene's materials."""

    rng: np.random.Generator
    materials: Materials

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def number(self, low: int, high: int) -> int:
        """Whole number from low to high, both included."""
        return int(self.rng.integers(low, high + 1))

    def one_of(self, choices: Sequence[Thing]) -> Thing:
        return choices[self.rng.integers(len(choices))]


Thing = Callable[[Kit], Parts]
"""Makes something that stands on the floor at the origin."""


def moved(parts: Parts, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Parts:
    return [(shape.moved(x, y, z), material) for shape, material in parts]


def turned(parts: Parts, matrix: np.ndarray) -> Parts:
    return [(shape.turned(matrix), material) for shape, material in parts]


def scaled(parts: Parts, factor: float) -> Parts:
    return [(Shape(s.corners * factor, s.normals, s.uv * factor, s.face), m) for s, m in parts]


def extent(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates, (3,) each."""
    lows = np.min([shape.corners.min(axis=(0, 1)) for shape, _ in parts], axis=0)
    highs = np.max([shape.corners.max(axis=(0, 1)) for shape, _ in parts], axis=0)
    return lows, highs


def footprint(parts: Parts) -> float:
    """Radius of the circle about the origin that the things stand on [m]."""
    return max(float(np.hypot(shape.corners[..., 0], shape.corners[..., 2]).max()) for shape, _ in parts)


def set_down(parts: Parts, y: float = 0.0) -> Parts:
    """Moved so that the middle is over the origin and the lowest point at height y."""
    low, high = extent(parts)
    return moved(parts, -(low[0] + high[0]) / 2, y - low[1], -(low[2] + high[2]) / 2)


@dataclass
class Ground:
    """A horizontal rectangle that things are put on without standing in each other."""

    kit: Kit
    x: tuple[float, float]
    z: tuple[float, float]
    y: float = 0.0

    def __post_init__(self) -> None:
        self._taken: list[tuple[float, float, float]] = []

    def take(self, x: float, z: float, radius: float) -> None:
        """Keep a circle free."""
        self._taken.append((x, z, radius))

    def put(self, parts: Parts, closeness: float = 0.85) -> Parts:
        """The things at a free place, or nothing where none is found."""
        radius = footprint(parts) * closeness
        for _ in range(12):
            x, z = self.kit.between(*self.x), self.kit.between(*self.z)
            if all((x - a) ** 2 + (z - b) ** 2 > (radius + r) ** 2 for a, b, r in self._taken):
                self.take(x, z, radius)
                return moved(parts, x, self.y, z)
        return []
