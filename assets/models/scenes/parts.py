"""Pieces of a scene: shapes with their materials, and how to set them down."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import ParamSpec

import numpy as np

from .materials import Materials
from .shapes import Shape

Arguments = ParamSpec("Arguments")

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


def one_object(make: Callable[Arguments, Parts]) -> Callable[Arguments, Parts]:
    """Decorator: what the function makes is one object, except shapes that belong to another already."""

    @wraps(make)
    def made(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Parts:
        owner = object()
        return [
            (replace(shape, owner=owner) if shape.owner is None else shape, material)
            for shape, material in make(*args, **kwargs)
        ]

    return made


def copied(parts: Parts) -> Parts:
    """The same shapes again, as other objects."""
    owners: dict[int, object] = {}
    return [
        (replace(shape, owner=None if shape.owner is None else owners.setdefault(id(shape.owner), object())), material)
        for shape, material in parts
    ]


def moved(parts: Parts, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Parts:
    return [(shape.moved(x, y, z), material) for shape, material in parts]


def turned(parts: Parts, matrix: np.ndarray) -> Parts:
    return [(shape.turned(matrix), material) for shape, material in parts]


def scaled(parts: Parts, factor: float) -> Parts:
    return [(shape.scaled(factor), material) for shape, material in parts]


def extent(parts: Parts) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates, (3,) each."""
    return np.min([shape.low for shape, _ in parts], axis=0), np.max([shape.high for shape, _ in parts], axis=0)


def height_of(parts: Parts) -> float:
    """Greatest height [m]."""
    return max(float(shape.high[1]) for shape, _ in parts)


def footprint(parts: Parts) -> float:
    """Radius of a circle about the origin that the things stand on, about [m]."""
    low, high = extent(parts)
    return float(np.hypot(*np.maximum(-low, high)[[0, 2]])) * 0.9


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
