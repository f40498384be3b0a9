"""Ties: results whose errors on the same pixels differ by less than can be told."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from .._runtime.formatting import millimetres
from .evaluation import Evaluated, margin_of_mean


@dataclass(frozen=True)
class Ties:
    """Which of several results have the smallest error.

    Attributes
    ----------
    best : int
        Number of the one with the smallest RMSE, the first of equals.
    equal : frozenset of int
        Those that cannot be told from it, and it itself: their RMSE differs by less than the margin, or not in the
        digits that are shown.
    within : float
        Largest difference of their RMSE from the smallest [m].
    """

    best: int
    equal: frozenset[int]
    within: float

    def __bool__(self) -> bool:
        """Whether there is more than one."""
        return len(self.equal) > 1


def find_ties(several: Sequence[Evaluated], able: Collection[int] | None = None) -> Ties | None:
    """Find the results with the smallest RMSE.

    Parameters
    ----------
    several : sequence of Evaluated
        On the same pixels, as by `restrict_to_shared`.
    able : collection of int, optional
        Only these may be the best; all with evaluated pixels if left out.

    Returns
    -------
    Ties or None
        None if nothing was evaluated.
    """
    among = range(len(several)) if able is None else able
    errors = {number: several[number].whole.rmse for number in among if several[number].whole.pixels}
    if not errors:
        return None
    best = min(errors, key=errors.__getitem__)
    equal = frozenset(number for number in errors if _are_equal(several[best], several[number]))
    return Ties(best, equal, max(errors[number] for number in equal) - errors[best])


def _are_equal(best: Evaluated, other: Evaluated) -> bool:
    """Whether the RMSE of two results of the same pixels cannot be told apart."""
    one, two = best.whole.rmse, other.whole.rmse
    if best is other or millimetres(one) == millimetres(two):
        return True
    differences, places = [], []
    for part, another in zip(best.evaluated, other.evaluated, strict=True):
        both = part.filled & another.filled
        squares = (np.square(errors.error[both], dtype=np.float64) for errors in (another, part))
        differences.append(np.subtract(*squares) / (one + two))  # the mean of these is the difference of the RMSE
        places.append(part.places[both])
    return two - one <= margin_of_mean(differences, places, best.labels.shape[1])
