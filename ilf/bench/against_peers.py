"""A method beside the best of all peers on every single frame: an opponent that nobody can pick in advance.

Means over frames are set by the few frames with the largest errors. A geometric mean of ratios takes all frames for the
same, whatever their scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SMALLEST_ERROR = 1e-6
"""Errors below this [m] count as this much: of no error at all there is no ratio."""

RESAMPLES = 10_000
_SEED = 0


@dataclass(frozen=True)
class AgainstPeers:
    """One measure of error of one method beside the best of all peers, frame by frame.

    Attributes
    ----------
    ratio : float
        Geometric mean over frames of its error / the smallest error of any peer on that very frame. For a peer, which
        is one of them, it is at least 1.
    low_68, high_68, low_95, high_95 : float or None
        Intervals of the ratio, from `bootstrap`; None where all frames are of one sensor.
    wins : int
        Frames on which its error is at most that of the best peer.
    """

    ratio: float
    low_68: float | None
    high_68: float | None
    low_95: float | None
    high_95: float | None
    wins: int


def against_peers(errors: Sequence[float], best: Sequence[float], sensors: Sequence[str]) -> AgainstPeers:
    """Compare a method's errors [m], frame by frame, with the best peers' on the same frames, of these sensors."""
    logarithms = np.log(_floored(errors)) - np.log(_floored(best))
    ratios = bootstrap(logarithms, sensors)
    low_68, high_68, low_95, high_95 = (
        [None] * 4 if ratios is None else np.quantile(ratios, (0.16, 0.84, 0.025, 0.975)).tolist()
    )
    return AgainstPeers(
        float(np.exp(logarithms.mean())), low_68, high_68, low_95, high_95, int(np.count_nonzero(logarithms <= 0))
    )


def geometric_mean(errors: Sequence[float]) -> float:
    """Geometric mean of errors [m], none of which counts as less than `SMALLEST_ERROR`.

    Examples
    --------
    >>> round(geometric_mean([0.1, 0.4]), 6)
    0.2
    """
    return float(np.exp(np.log(_floored(errors)).mean()))


def bootstrap(logarithms: NDArray[np.float64], groups: Sequence[str]) -> NDArray[np.float64] | None:
    """Geometric means as they would have been with other groups of frames, always the same; None for a single group.

    As many groups as there are, are drawn with replacement, each with all of its frames, `RESAMPLES` times: frames of
    one sensor resemble each other and say less than as many different ones.

    Parameters
    ----------
    logarithms : ndarray of float64, shape (N,)
        Of what is averaged.
    groups : sequence of str
        The group of each.
    """
    names, group = np.unique(np.asarray(groups), return_inverse=True)
    if names.size < 2:
        return None
    drawn = np.random.default_rng(_SEED).multinomial(names.size, np.full(names.size, 1 / names.size), RESAMPLES)
    return np.exp((drawn @ np.bincount(group, logarithms)) / (drawn @ np.bincount(group)))


def _floored(errors: Sequence[float]) -> NDArray[np.float64]:
    return np.maximum(np.asarray(errors, np.float64), SMALLEST_ERROR)
