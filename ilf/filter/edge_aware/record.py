"""The record of one iteration of the edge-aware filter."""

from __future__ import annotations

from dataclasses import dataclass

from ..convergence import IterationRecord


@dataclass(frozen=True, slots=True, eq=False)
class EdgeAwareRecord(IterationRecord):
    """What one iteration of the edge-aware filter did. A stage is one grid, or one round on the finest.

    Attributes
    ----------
    cell : int
        Side of the cells of the grid that the iteration worked on [px]; 1 on the finest.
    round : int
        Which of the rounds in which jumps let go, from 1; 0 before them.
    """

    cell: int
    round: int
