"""The record of one iteration in a pass band."""

from __future__ import annotations

from dataclasses import dataclass

from ..convergence import IterationRecord


@dataclass(frozen=True, slots=True, eq=False)
class PassBandRecord(IterationRecord):
    """What one iteration of the ideal low-pass filter did. A stage is one pass band.

    Attributes
    ----------
    radii : tuple of float
        Cut-off radii (r_y, r_x) of this iteration, in cycles per padded grid.
    weighted : bool
        Whether the colour spectrum weighted this iteration.
    """

    radii: tuple[float, float]
    weighted: bool
