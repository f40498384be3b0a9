"""The record of one iteration, and the two curves that it carries."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class IterationRecord:
    """What one iteration did.

    Attributes
    ----------
    i : int
        Number of the iteration, from 1.
    stage : int
        How many different pass bands there have been, from 1.
    radii : tuple of float
        Cut-off radii (r_y, r_x) of this iteration, in cycles per padded grid.
    sigma_i : float
        Deviation between P_i and P_(i-1) over the block [m], Eq. (2).
    l1 : float
        L1 norm of P_i over the block [m]: the sum of its absolute values.
    weighted : bool
        Whether the colour spectrum weighted this iteration.
    seconds : float
        Time since the block's iteration was set up [s].
    """

    i: int
    stage: int
    radii: tuple[float, float]
    sigma_i: float
    l1: float
    weighted: bool
    seconds: float


def deviation(current: NDArray[np.float64], previous: NDArray[np.float64]) -> float:
    """sigma_i = sqrt(sum (P_i - P_(i-1))^2 / N), Eq. (2); the arguments hold the block's N pixels [m]."""
    difference = current - previous
    return float(np.sqrt(np.mean(difference * difference)))


def l1_norm(values: NDArray[np.float64]) -> float:
    """Sum of absolute values of P_i over the block's pixels [m]."""
    return float(np.sum(np.abs(values)))
