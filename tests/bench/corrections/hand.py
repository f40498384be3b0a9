"""A user's actions as plain data, and the tremor of the hand."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .targets import Point

STEP = 2.0
"""Distance of two mouse moves [image px]."""
TREMOR = 1.5
"""Maximum offset of the hand from the intended line, in x and y [image px]."""
_CALM = 12.0
"""Approximate length over which the hand keeps to one side [image px]."""


@dataclass(frozen=True)
class Use:
    """Activate a tool by the key of the action `tool_...`; nothing if it is active."""

    tool: str


@dataclass(frozen=True)
class Brush:
    """Set the radius of the brush [image px] by presses of [ or ]."""

    radius: float


@dataclass(frozen=True)
class Click:
    """One click in the colour view, or a double click."""

    x: float
    y: float
    ctrl: bool = False
    shift: bool = False
    alt: bool = False
    double: bool = False
    right: bool = False


@dataclass(frozen=True)
class Stroke:
    """Press, draw along a path by hand, release."""

    path: tuple[Point, ...]
    ctrl: bool = False
    shift: bool = False
    alt: bool = False


@dataclass(frozen=True)
class Command:
    """The key of any other action of the window, by the action's name."""

    name: str


@dataclass(frozen=True)
class Key:
    """Any other key, as Qt names it: "Return", "Escape", "Backspace"."""

    name: str


@dataclass(frozen=True)
class Wasted:
    """The last inputs were in vain.

    Attributes
    ----------
    inputs : int
        Their number: clicks, strokes and keys.
    """

    inputs: int


Action = Use | Brush | Click | Stroke | Command | Key | Wasted


def stroke(*path: Point) -> Stroke:
    """Make a stroke along a line through points."""
    return Stroke(path)


def by_hand(path: Sequence[Point], name: str) -> list[Point]:
    """Return the mouse positions of a hand that follows a path; the same for the same name.

    Smooth noise of at most `TREMOR` pixels in x and in y, on points that are about `STEP` pixels apart.
    """
    points = _resampled(path)
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    # long enough for noise without edge effects, whatever the length of the path
    margin = math.ceil(4 * _CALM / STEP)
    noise = gaussian_filter1d(rng.normal(size=(len(points) + 2 * margin, 2)), _CALM / STEP / 2, axis=0)[margin:-margin]
    # filtered noise has the deviation 1 / sqrt(2 sigma sqrt(pi)); it is scaled to half of the tremor
    scale = TREMOR / 2 * math.sqrt(2 * (_CALM / STEP / 2) * math.sqrt(math.pi))
    off = np.clip(noise * scale, -TREMOR, TREMOR)
    return [(x + dx, y + dy) for (x, y), (dx, dy) in zip(points, off, strict=True)]


def _resampled(path: Sequence[Point]) -> list[Point]:
    points = [path[0]]
    for start, end in itertools.pairwise(path):
        count = max(math.ceil(math.dist(start, end) / STEP), 1)
        points += [
            (start[0] + (end[0] - start[0]) * k / count, start[1] + (end[1] - start[1]) * k / count)
            for k in range(1, count + 1)
        ]
    return points
