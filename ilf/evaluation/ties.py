"""Ties: results whose errors on the same pixels differ by less than can be told."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from .._runtime.formatting import millimetres
from .evaluation import Evaluated

_CELL = 16
"""Side [px] of the squares whose errors count as one observation: errors of neighbouring pixels are alike."""

_PROBABILITY = 0.95
"""Probability that the true mean lies within the margin."""


def margin_of_mean(values: Sequence[NDArray[np.floating]], places: Sequence[NDArray[np.intp]], width: int) -> float:
    """Half the width of the 95 % confidence interval of the mean of values at pixels, over several frames.

    Parameters
    ----------
    values : sequence of ndarray of float, shape (N,)
        One array per frame.
    places : sequence of ndarray of int, shape (N,)
        The flat indices of their pixels.
    width : int
        Width of the frames [px].

    Returns
    -------
    float
        In the unit of the values; infinite if the pixels lie in fewer than two squares of 16 px.

    Examples
    --------
    >>> margin_of_mean([np.array([1.0, 1.0, 3.0, 3.0])], [np.array([0, 1, 20, 21])], 64) > 10
    True
    """
    sums, sizes = [], []
    mean = sum(float(part.sum(dtype=np.float64)) for part in values) / max(sum(part.size for part in values), 1)
    for part, at in zip(values, places, strict=True):
        rows, columns = np.divmod(at, width)
        cells = rows // _CELL * (width // _CELL + 1) + columns // _CELL
        sums.append(np.bincount(cells, part.astype(np.float64) - mean)[np.bincount(cells) > 0])
        sizes.append(part.size)
    count = sum(part.size for part in sums)
    if count < 2:
        return math.inf
    deviation = math.sqrt(sum(float(np.sum(part**2)) for part in sums) * count / (count - 1)) / sum(sizes)
    return float(stdtrit(count - 1, (1 + _PROBABILITY) / 2)) * deviation


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
