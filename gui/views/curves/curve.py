"""A curve: the iterations of one block in one run, as numbers to plot. No widgets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ilf.data.results import IterationRecord

Values = NDArray[np.float64]

FLOOR = 1e-6
"""Smaller lengths [m], including zero, are drawn at this value on the logarithmic axis."""

QUANTITIES = ("sigma_i", "error", "held_out", "residual", "l1")
"""Fields of an `IterationRecord` that are plotted."""

_MIN_LUMINANCE, _MAX_LUMINANCE = 0.4, 0.5
"""Minimum luminance of lines on a dark background, maximum on a light one."""

_LENGTHS = ("sigma_i", "error", "held_out", "residual")
_STAGE, _WEIGHTED = -2, -1
"""Columns of the table of a curve."""


@dataclass(frozen=True, eq=False)
class Curve:
    """The iterations of one block in one run, with name and style.

    Attributes
    ----------
    name : str
        Name of the block or run.
    colour : tuple of int
        Red, green, blue.
    records : sequence of IterationRecord
        May grow at its end: the curve is of those that there are when it is first drawn.
    dashed : bool
        Whether it belongs to a compared run.
    s_criteria : float or None
        The stop criterion [m] of the block; None if a run does not use it.
    remark : str
        Remark on the criterion.
    limit : str
        Sentence on the limit at which the iteration ended; "" if it has converged, or is running.
    corrected : float
        Error [m] against ground truth after the learned correction, which follows the last iteration; NaN without
        correction or ground truth.
    """

    name: str
    colour: tuple[int, int, int]
    records: Sequence[IterationRecord]
    dashed: bool = False
    s_criteria: float | None = None
    remark: str = ""
    limit: str = ""
    corrected: float = math.nan

    @property
    def title(self) -> str:
        """The name, and that it has not converged."""
        return f"{self.name}: not converged" if self.limit else self.name

    @cached_property
    def _table(self) -> Values:
        """Numbers of the iterations that there are now: one row each, with lengths as log10."""
        rows = [
            (r.i, r.seconds, r.sigma_i, r.error, r.held_out, r.residual, r.l1, r.stage, getattr(r, "weighted", False))
            for r in self.records
        ]
        table = np.array(rows, np.float64).reshape(-1, 4 + len(QUANTITIES))
        lengths = table[:, 2 : 2 + len(_LENGTHS)]
        lengths[:] = np.log10(np.maximum(lengths, FLOOR))
        return table

    @property
    def count(self) -> int:
        """Number of iterations."""
        return len(self._table)

    @property
    def stages(self) -> list[int]:
        """Starts of stages that follow a stage of more than one iteration."""
        changes = np.diff(self._table[:, _STAGE]) != 0
        return (np.flatnonzero(changes[1:] & ~changes[:-1]) + 2).tolist()

    @property
    def has_times(self) -> bool:
        """Whether the time of the iterations is known: not of those that a run record has kept."""
        return not np.isnan(self._table[:, 1]).any()

    def along(self, by_time: bool) -> Values:
        """Positions of the iterations: their numbers, or seconds since the start of the block."""
        return self._table[:, int(by_time)]

    def values(self, quantity: str) -> Values:
        """One of `QUANTITIES`: log10 of a length [m], or a sum [m]; NaN where unknown.

        "l1_left" is the difference of the L1 norm to its last value [%], comparable between blocks of any size.
        """
        if quantity == "l1_left":
            sums = self.values("l1")
            return 100 * (sums / sums[-1] - 1) if sums[-1] else np.zeros(self.count)
        return self._table[:, 2 + QUANTITIES.index(quantity)]

    def has(self, quantity: str) -> bool:
        """Whether the quantity has any finite value."""
        return bool(np.isfinite(self.values(quantity)).any())

    def between(self, place: int, by_time: bool) -> float:
        """Position half-way between an iteration and the one before it."""
        along = self.along(by_time)
        return float(along[place - 1] + along[place]) / 2

    def weighted(self, by_time: bool) -> tuple[float, float] | None:
        """Span of the colour-weighted iterations; None if there are none."""
        places = np.flatnonzero(self._table[:, _WEIGHTED])
        if not places.size:
            return None
        along = self.along(by_time)
        margin = 0.0 if by_time else 0.5
        return float(along[places[0]]) - margin, float(along[places[-1]]) + margin

    def nearest(self, where: float, by_time: bool) -> int:
        """Index of the iteration nearest to a position on the axis."""
        along = self.along(by_time)
        after = int(np.searchsorted(along, where))
        if after == 0 or after == self.count:
            return min(after, self.count - 1)
        return after if along[after] - where < where - along[after - 1] else after - 1


def legible(colour: tuple[int, int, int], is_dark: bool) -> tuple[int, int, int]:
    """Darken a colour for thin lines on a light background, or lighten it for a dark one.

    Examples
    --------
    >>> legible((255, 255, 0), is_dark=False), legible((255, 255, 0), is_dark=True)
    ((143, 143, 0), (255, 255, 0))
    """
    red, green, blue = (part / 255 for part in colour)
    luminance = 0.3 * red + 0.59 * green + 0.11 * blue
    if is_dark:
        share = max(_MIN_LUMINANCE - luminance, 0) / (1 - luminance) if luminance < 1 else 0.0
        parts = [part + share * (1 - part) for part in (red, green, blue)]
    else:
        share = min(_MAX_LUMINANCE / luminance, 1) if luminance else 1.0
        parts = [share * part for part in (red, green, blue)]
    return round(255 * parts[0]), round(255 * parts[1]), round(255 * parts[2])
