"""The record of one iteration, the curves that it carries, and the pixels that one of them takes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..equality import NanEqual

_SEED = 0


@dataclass(frozen=True, slots=True, eq=False)
class IterationRecord(NanEqual):
    """What one iteration did, whatever the filter. NaN equals NaN when records are compared.

    Attributes
    ----------
    i : int
        Number of the iteration, from 1.
    stage : int
        Number of the stage, from 1: a stretch of iterations that all let the same through, after which the filter lets
        more through.
    sigma_i : float
        Deviation between P_i and P_(i-1) over the block [m], Eq. (2).
    l1 : float
        L1 norm of P_i over the block [m]: the sum of its absolute values.
    residual : float
        Root mean square of P_i - raw [m] over the block's known pixels that the iteration takes; NaN if there are
        none.
    held_out : float
        The same over the known pixels that are held out of it; NaN if there are none. Its minimum says where noise
        begins to come in with the band, which sigma_i does not see.
    seconds : float
        Time since the block's iteration was set up [s].
    error : float
        Root mean square of P_i - truth [m] over the block's pixels without known depth, where the frame's truth is
        known (`RGBDFrame.truth`); NaN if there are none. It is measured after the iteration, which knows nothing of it.
    """

    i: int
    stage: int
    sigma_i: float
    l1: float
    residual: float
    held_out: float
    seconds: float
    error: float = field(default=math.nan, kw_only=True)


def held_out_of(known: NDArray[np.bool_], share: float) -> NDArray[np.bool_]:
    """Known pixels to hold out of a block's iteration: a fixed choice, whatever else the frame holds.

    Parameters
    ----------
    known : ndarray of bool, shape (h, w)
        The block's known pixels on its bounding box.
    share : float
        Share of them to hold out, below 1: at least one known pixel is left.

    Returns
    -------
    ndarray of bool, shape (h, w)
    """
    held = np.zeros(known.shape, bool)
    if share == 0:
        return held
    places = np.flatnonzero(known)
    chosen = np.random.default_rng(_SEED).permutation(places)[: int(share * places.size)]
    held.flat[chosen] = True
    return held


def deviation(current: NDArray[np.float64], previous: NDArray[np.float64]) -> float:
    """sigma_i = sqrt(sum (P_i - P_(i-1))^2 / N), Eq. (2); the arguments hold the block's N pixels [m]."""
    difference = current - previous
    return float(np.sqrt(np.mean(difference * difference)))


def l1_norm(values: NDArray[np.float64]) -> float:
    """Sum of absolute values of P_i over the block's pixels [m]."""
    return float(np.sum(np.abs(values)))
