"""What has been measured: as rows of a list, as texts over the pictures, as a table for other programs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gui.inspect.measure_panel import MeasuredRow
from gui.inspect.statistics_table import degrees, metres
from gui.state.chains import Point
from ilf.inspection import Measured

Chain = Sequence[Point]
Length = tuple[Point, str]
Angle = tuple[Point, Point, str]


def measured_rows(chains: Sequence[Chain], found: Sequence[Measured], known: NDArray[np.bool_]) -> list[MeasuredRow]:
    """A row for every stretch; `known`, bool (H, W), says where depth was measured."""
    rows = []
    for number, (chain, measured) in enumerate(zip(chains, found, strict=True)):
        several = len(chain) > 2
        for n, (distance, height) in enumerate(zip(measured.distances, measured.heights, strict=True)):
            ends = (chain[n], chain[n + 1])
            rows.append(
                MeasuredRow(
                    number,
                    f"{number + 1}.{n + 1}" if several else f"{number + 1}",
                    metres(distance) if math.isfinite(distance) else "no depth",
                    f"{height:+.3f} m" if math.isfinite(height) else "–",
                    degrees(measured.angles[n]) if n else "",
                    any(not known[math.floor(y), math.floor(x)] for x, y in ends),
                )
            )
        if several:
            rows.append(MeasuredRow(number, f"{number + 1}  all", metres(measured.length), "", "", False))
    return rows


def texts_of(chains: Sequence[Chain], found: Sequence[Measured]) -> tuple[list[Length], list[Angle]]:
    """What is written at the middle of every stretch, and what at every corner, outside of it."""
    lengths: list[Length] = []
    angles: list[Angle] = []
    for number, (chain, measured) in enumerate(zip(chains, found, strict=True)):
        for n, distance in enumerate(measured.distances):
            name = f"{number + 1}: " if n == 0 and len(chains) > 1 else ""
            length = metres(distance) if math.isfinite(distance) else "no depth"
            lengths.append((_middle(chain[n], chain[n + 1]), f"{name}{length}"))
        for n in range(1, len(chain) - 1):
            if math.isfinite(measured.angles[n]):
                angles.append((chain[n], _middle(chain[n - 1], chain[n + 1]), degrees(measured.angles[n])))
    return lengths, angles


def _middle(one: Point, other: Point) -> Point:
    return (one[0] + other[0]) / 2, (one[1] + other[1]) / 2
