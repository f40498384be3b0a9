"""Levels of the pyramid over a block's window, and how surfaces get from one to the next finer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..pyramid import enlarged, largest_of_four, sums_of_four
from .kernels import Sums, tally
from .parting import Parting

Array = NDArray[np.float32]


class Level(NamedTuple):
    """What surfaces need to know of a grid to get from it to the next finer one."""

    shape: tuple[int, ...]
    parting: Parting | None

    def enlarged(self, u: Array, finer: Level) -> Array:
        """A surface on this grid on the next finer one."""
        if self.parting is None or finer.parting is None:
            return enlarged(u, finer.shape)
        return self.parting.enlarged(u, finer.parting)


@dataclass(frozen=True, eq=False)
class Grid:
    """A level of the pyramid over the window.

    `counts` and `totals` are of the known depth less the trend, `inside` counts the block's pixels in every cell;
    `edges` is the largest edge strength there, `creases` the largest probability of a crease, or None where nothing
    tells of them. `held_out` is counts and totals of the depth that is held out, or None; `parting` is what a drawn
    border parts, or None.
    """

    cell: int
    counts: Array
    totals: Array
    inside: Array
    trend: Array
    edges: Array
    creases: Array | None
    held_out: tuple[Array, Array] | None
    parting: Parting | None

    @property
    def coarseness(self) -> int:
        """How many levels it is above the finest."""
        return self.cell.bit_length() - 1

    @cached_property
    def samples(self) -> float:
        """How many pixels of known depth there are."""
        return float(self.counts.sum(dtype=np.float64))

    @property
    def start(self) -> Array:
        """The cells' known depth less the trend; 0 where there is none."""
        return np.divide(self.totals, np.maximum(self.counts, 1))

    def sums(self, u: Array, previous: Array) -> Sums:
        """What there is to tell of a step to u."""
        return Sums(*tally(u, previous, self.inside, self.trend, self.counts, self.totals))

    def smooth(self, edge_scale: float) -> tuple[Array, Array]:
        """How much smoothness is left between neighbours along x and y: as much as in the lesser of the two."""
        left = np.exp(-self.edges / np.float32(edge_scale))
        smooth = np.minimum(left[:, 1:], left[:, :-1]), np.minimum(left[1:], left[:-1])
        return smooth if self.parting is None else self.parting.cut(*smooth)

    @property
    def stiff(self) -> Array | None:
        """How much of the bending counts around every cell; None for all."""
        return None if self.creases is None else 1 - self.creases

    @property
    def level(self) -> Level:
        """What surfaces need to know of it."""
        return Level(self.counts.shape, self.parting)

    def halved(self) -> Grid:
        """The next level: cells of twice the size."""
        counts, totals, edges = self.counts, self.totals, self.edges
        if self.parting is not None:
            counts, totals, edges = (
                np.where(self.parting.kept, values, np.float32(0)) for values in (counts, totals, edges)
            )
        return Grid(
            cell=2 * self.cell,
            counts=sums_of_four(counts),
            totals=sums_of_four(totals),
            inside=sums_of_four(self.inside),
            trend=np.float32(0.25) * sums_of_four(self.trend, "edge"),
            edges=largest_of_four(edges),
            creases=None if self.creases is None else largest_of_four(self.creases),
            held_out=self.held_out and (sums_of_four(self.held_out[0]), sums_of_four(self.held_out[1])),
            parting=self.parting and self.parting.halved(),
        )
