"""Kinds of scene, each made anew at random."""

from __future__ import annotations

from collections.abc import Callable

from .indoors import corridor, room, seating, stairwell
from .jumble import jumble
from .near_by import picking, shelves, tabletop, worktop
from .outside import outdoors
from .parts import Kit
from .receding import hall, street
from .setting import Setting

LAYOUTS: tuple[tuple[Callable[[Kit], Setting], float], ...] = (
    (room, 0.28), (corridor, 0.07), (hall, 0.31), (tabletop, 0.22), (picking, 0.12), (shelves, 0.08), (worktop, 0.06),
    (seating, 0.05), (outdoors, 0.08), (street, 0.14), (stairwell, 0.08), (jumble, 0.03),
)  # fmt: skip
