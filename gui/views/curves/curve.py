"""A curve: the iterations of one block in one run, as numbers that can be drawn. No widgets."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import length_text
from ilf.data.results import EdgeAwareRecord, IterationRecord, PassBandRecord

from .readout import Column

Values = NDArray[np.float64]

FLOOR = 1e-6
"""Smaller lengths [m], zero included, are drawn here: a logarithmic axis has no zero."""

QUANTITIES = ("sigma_i", "error", "held_out", "residual", "l1")
"""Of an `IterationRecord`, what is drawn."""

_LEAST_LIGHT, _MOST_LIGHT = 0.4, 0.5
"""Luminances of lines on a dark ground and on a light one."""

_LENGTHS = ("sigma_i", "error", "held_out", "residual")


@dataclass(frozen=True, eq=False)
class Curve:
    """The iterations of one block in one run, and how they are told from others.

    Attributes
    ----------
    name : str
        Of block or run.
    colour : tuple of int
        Red, green, blue.
    records : sequence of IterationRecord
        May grow at its end.
    dashed : bool
        Whether it is of a run that is compared.
    s_criteria : float or None
        The stop criterion [m] of the block; None where it has no part in a run.
    remark : str
        What is to be said of that criterion.
    corrected : float
        Error [m] against the truth after the learned correction, which follows the last iteration; NaN where there was
        none or the truth is not known.
    """

    name: str
    colour: tuple[int, int, int]
    records: Sequence[IterationRecord]
    dashed: bool = False
    s_criteria: float | None = None
    remark: str = ""
    corrected: float = math.nan

    def looks_like(self, other: Curve) -> bool:
        """Whether the other has the same looks, whatever its records."""
        return (self.name, self.colour, self.dashed) == (other.name, other.colour, other.dashed)


def legible(colour: tuple[int, int, int], is_dark: bool) -> tuple[int, int, int]:
    """The same colour as dark, or as light, as a thin line has to be on a light ground, or a dark one.

    Examples
    --------
    >>> legible((255, 255, 0), is_dark=False), legible((255, 255, 0), is_dark=True)
    ((143, 143, 0), (255, 255, 0))
    """
    red, green, blue = (part / 255 for part in colour)
    luminance = 0.3 * red + 0.59 * green + 0.11 * blue
    if is_dark:
        share = max(_LEAST_LIGHT - luminance, 0) / (1 - luminance) if luminance < 1 else 0.0
        parts = [part + share * (1 - part) for part in (red, green, blue)]
    else:
        share = min(_MOST_LIGHT / luminance, 1) if luminance else 1.0
        parts = [share * part for part in (red, green, blue)]
    return round(255 * parts[0]), round(255 * parts[1]), round(255 * parts[2])


class Columns:
    """The numbers of a curve, column by column: what has been read of its records is not read again.

    Attributes
    ----------
    count : int
        Iterations.
    stages : list of int
        Where a stage begins after one of some length: where one begins every time there is nothing to mark.
    """

    def __init__(self) -> None:
        self.count = 0
        self.stages: list[int] = []
        self._table = np.zeros((0, 2 + len(QUANTITIES)))
        self._records: Sequence[IterationRecord] = ()
        self._weighted: list[int] = []

    def take(self, records: Sequence[IterationRecord]) -> None:
        """Read the records; those that it has already must be at their beginning, unless it is another sequence."""
        if records is not self._records:
            self.count = 0
            self.stages, self._weighted, self._records = [], [], records
        fresh = records[self.count :]
        count = self.count + len(fresh)
        if count > len(self._table):
            table = np.zeros((max(2 * len(self._table), count, 64), self._table.shape[1]))
            table[: self.count] = self._table[: self.count]
            self._table = table
        if fresh:
            rows = [(r.i, r.seconds, r.sigma_i, r.error, r.held_out, r.residual, r.l1) for r in fresh]
            self._table[self.count : count] = rows
            lengths = self._table[self.count : count, 2 : 2 + len(_LENGTHS)]
            lengths[:] = np.log10(np.maximum(lengths, FLOOR))
        for place in range(self.count, count):
            if place >= 2 and records[place].stage != records[place - 1].stage == records[place - 2].stage:
                self.stages.append(place)
            record = records[place]
            if isinstance(record, PassBandRecord) and record.weighted:
                self._weighted.append(place)
        self.count = count

    def along(self, by_time: bool) -> Values:
        """Where the iterations stand: their number, or the seconds since the block was begun."""
        return self._table[: self.count, int(by_time)]

    def values(self, quantity: str) -> Values:
        """One of `QUANTITIES`: log10 of a length [m], or a sum [m]; NaN where it is not known.

        "l1_left" is by how much the L1 norm differs from the last one [%], which blocks of any size have in common.
        """
        if quantity == "l1_left":
            sums = self.values("l1")
            return 100 * (sums / sums[-1] - 1) if sums[-1] else np.zeros(self.count)
        return self._table[: self.count, 2 + QUANTITIES.index(quantity)]

    def has(self, quantity: str) -> bool:
        """Whether there is any such value."""
        return bool(np.isfinite(self.values(quantity)).any())

    def between(self, place: int, by_time: bool) -> float:
        """Half-way between an iteration and the one before it."""
        along = self.along(by_time)
        return float(along[place - 1] + along[place]) / 2

    def weighted(self, by_time: bool) -> tuple[float, float] | None:
        """From where to where the colour weighted the iterations; None if it did not."""
        if not self._weighted:
            return None
        if not by_time:
            return self._weighted[0] + 0.5, self._weighted[-1] + 1.5
        along = self.along(by_time)
        return float(along[self._weighted[0]]), float(along[self._weighted[-1]])

    def nearest(self, where: float, by_time: bool) -> int:
        """Which iteration is nearest to a place on the axis."""
        along = self.along(by_time)
        after = int(np.searchsorted(along, where))
        if after == 0 or after == self.count:
            return min(after, self.count - 1)
        return after if along[after] - where < where - along[after - 1] else after - 1


# What the readout says of an iteration, column by column. No widgets.

_LENGTH = "0.000 mm"

Numbers = Iterator[tuple[Column, str]]


def readout_columns(records: Sequence[IterationRecord], has: Mapping[str, bool], by_time: bool) -> list[Column]:
    """The columns for some curves' iterations, the most telling first.

    Parameters
    ----------
    records : sequence of IterationRecord
        One of each curve.
    has : mapping of str to bool
        Whether any of the curves has an "error", or a "held_out".
    by_time : bool
        Whether the time matters most.
    """
    return [column for column, _ in _numbers(records[0], has, by_time, len(records) == 1)] if records else []


def readout_texts(records: Sequence[IterationRecord], has: Mapping[str, bool], by_time: bool) -> list[tuple[str, ...]]:
    """The texts in those columns, row by row."""
    return [tuple(text for _, text in _numbers(record, has, by_time, len(records) == 1)) for record in records]


def _numbers(record: IterationRecord, has: Mapping[str, bool], by_time: bool, alone: bool) -> Numbers:
    time = Column("", "000.00 s"), f"{record.seconds:.2f} s"
    yield Column("i", "0000"), f"{record.i}"
    if by_time:
        yield time
    yield Column("σ", _LENGTH), length_text(record.sigma_i)
    if has["error"]:
        yield Column("err", _LENGTH), length_text(record.error)
    if has["held_out"]:
        yield Column("hold-out", _LENGTH), length_text(record.held_out)
    yield Column("L1", "000,000 m"), f"{record.l1:,.4g} m" if record.l1 < 1e4 else f"{record.l1:,.0f} m"
    if alone:
        yield from _own(record)
    yield Column("stage", "000"), f"{record.stage}"
    yield Column("residual", _LENGTH), length_text(record.residual)
    if not by_time:
        yield time


def _own(record: IterationRecord) -> Numbers:
    """What a filter says of its iteration besides what all of them say."""
    if isinstance(record, PassBandRecord):
        yield Column("radii", "000.0 × 000.0"), f"{record.radii[0]:.1f} × {record.radii[1]:.1f}"
    elif isinstance(record, EdgeAwareRecord):
        yield Column("cells", "00 px"), f"{record.cell} px"
        yield Column("round", "0"), f"{record.round or '–'}"
