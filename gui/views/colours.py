"""Lookup tables from 8-bit indices to the colours of depth, difference, error and edge strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray

DEPTH_MAPS = {
    "turbo": "turbo",
    "viridis": "viridis",
    "cividis": "cividis",
    "magma": "magma",
    "grey": "CET-L1",
}
"""Colour maps offered for depth: our name -> pyqtgraph's."""

_ERROR_MAP = "inferno"
_STRENGTH_MAP = "magma"


def depth_table(name: str) -> NDArray[np.uint8]:
    """Lookup table of a depth map, uint8 (256, 4) RGBA; index 0 (missing) is transparent.

    Raises
    ------
    ValueError
        If the name is not in `DEPTH_MAPS`.
    """
    if name not in DEPTH_MAPS:
        raise ValueError(f"Depth colour map must be one of {', '.join(DEPTH_MAPS)}, not {name!r}.")
    return _table(DEPTH_MAPS[name])


def difference_table(dark: bool) -> NDArray[np.uint8]:
    """Diverging table, blue below and red above, whose zero is near the background of the theme."""
    return _table("CET-D4" if dark else "CET-D1")


def error_table() -> NDArray[np.uint8]:
    """Lookup table of expected errors, from small and dark to large and bright."""
    return _table(_ERROR_MAP)


def strength_table() -> NDArray[np.uint8]:
    """Lookup table of edge strength, from none and dark to sure and bright."""
    return _table(_STRENGTH_MAP)


def _table(name: str) -> NDArray[np.uint8]:
    table = np.zeros((256, 4), np.uint8)
    table[1:, :3] = pg.colormap.get(name).getLookupTable(nPts=255)[:, :3]
    table[1:, 3] = 255
    return table


# Which numbers the ends of the colours stand for. No Qt.

Levels = tuple[float, float]

KINDS = {"depth": "m", "signed": "mm", "expected": "mm"}
"""Ranges that there are, and their units: of all depths, of differences and errors, of expected errors."""
ROBUST, FULL, FIXED = "robust", "full", "fixed"
MODES = {ROBUST: "Robust", FULL: "Full", FIXED: "Fixed"}
"""Ways to a range: what nearly all values lie in; what all of them lie in; two numbers."""


@dataclass
class Range:
    """How the levels of one kind are found.

    Attributes
    ----------
    mode : str
        One of `MODES`.
    levels : (float, float) or None
        The last levels, or the fixed ones.
    locked : bool
        Whether they stay as they are, whatever is shown.
    """

    mode: str = ROBUST
    levels: Levels | None = None
    locked: bool = False

    def find(self, robust: Callable[[], Levels], full: Callable[[], Levels]) -> Levels:
        """The levels for values whose robust and full ones are these."""
        if self.levels is None or not (self.locked or self.mode == FIXED):
            self.levels = full() if self.mode == FULL else robust()
        return self.levels

    def turn_to_another_frame(self) -> None:
        """Numbers that were set for a frame go with it, unless they are locked."""
        if not self.locked:
            self.levels = None
            if self.mode == FIXED:
                self.mode = ROBUST
