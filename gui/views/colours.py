"""Lookup tables from 8-bit indices to the colours of depth, difference, error and edge strength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtGui import QColor

DEPTH_MAPS = {
    "viridis": "viridis",
    "cividis": "cividis",
    "magma": "magma",
    "grey": "CET-L1",
    "turbo": "turbo",
}
"""Colour maps offered for depth: our name -> pyqtgraph's. All but turbo are perceptually uniform, and can be read by
colour-blind people."""
DEPTH_MAP = "viridis"
"""The one of a first start."""

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
    """Diverging table, blue below and red above; zero is close to the theme's background."""
    return _table("CET-D4" if dark else "CET-D1")


def error_table() -> NDArray[np.uint8]:
    """Lookup table of expected errors: small is dark, large is bright."""
    return _table(_ERROR_MAP)


def strength_table() -> NDArray[np.uint8]:
    """Lookup table of edge strength: weak is dark, strong is bright."""
    return _table(_STRENGTH_MAP)


def mark_table(*colours: QColor) -> NDArray[np.uint8]:
    """Table that maps 1, 2, ... to these colours, and 0 to transparent."""
    table = np.zeros((256, 4), np.uint8)
    for index, colour in enumerate(colours, 1):
        table[index] = colour.red(), colour.green(), colour.blue(), colour.alpha()
    return table


def _table(name: str) -> NDArray[np.uint8]:
    table = np.zeros((256, 4), np.uint8)
    table[1:, :3] = pg.colormap.get(name).getLookupTable(nPts=255)[:, :3]
    table[1:, 3] = 255
    return table


# Values at the ends of the colours. No Qt.

Levels = tuple[float, float]

KINDS = {"depth": "m", "signed": "mm", "expected": "mm"}
"""Kinds of colour ranges and their units: all depths, differences and errors, expected errors."""
ROBUST, FULL, FIXED = "robust", "full", "fixed"
MODES = {ROBUST: "Robust", FULL: "Full", FIXED: "Fixed"}
"""Modes of a range: contains nearly all values; contains all values; two fixed numbers."""


def full_levels(values: NDArray[np.floating]) -> Levels:
    """Minimum and maximum of the finite values, at least slightly apart; (0, 1) if there are none."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0
    low, high = float(known.min()), float(known.max())
    return (low, high) if high - low > 1e-3 else (low - 0.05, high + 0.05)


@dataclass
class Range:
    """Colour range of one kind.

    Attributes
    ----------
    mode : str
        One of `MODES`.
    levels : (float, float) or None
        Last or fixed values at the ends.
    locked : bool
        Whether the ends never change with the data.
    """

    mode: str = ROBUST
    levels: Levels | None = None
    locked: bool = False

    def find(self, robust: Callable[[], Levels], full: Callable[[], Levels]) -> Levels:
        """Ends of the range for data with these robust and full ranges."""
        if self.levels is None or not (self.locked or self.mode == FIXED):
            self.levels = full() if self.mode == FULL else robust()
        return self.levels

    def reset_for_frame(self) -> None:
        """Drop the fixed values of the last frame, unless they are locked."""
        if not self.locked:
            self.levels = None
            if self.mode == FIXED:
                self.mode = ROBUST
