"""The model of the expected error: from features of a filled pixel to its error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import compiled
from .features import FEATURES, FLOOR

WITHIN = 0.6827
"""Wanted share of errors within the expected error: as for one standard deviation."""

WITHIN_TWICE = 0.9545
"""Wanted share of errors within twice the expected error: as for two standard deviations."""

_GAP = list(FEATURES).index("gap")
_NARROW, _WIDE = np.log(2.0), np.log(8.0)
"""Logarithms of the gap widths [px] up to which a frame's difficulty has no effect, and from which its full effect."""

_MAX_DEVIATION = 0.5
"""Maximum deviation of a frame's difficulty from the usual one."""


Curve = tuple[tuple[float, ...], tuple[float, ...]]
"""Contribution of one feature to the logarithm of the expected error, linear between knots and constant beyond: the
knots, and its values there."""


@dataclass(frozen=True)
class ErrorModel:
    """Logarithm of the expected error as a share of depth: a sum of curves.

    Attributes
    ----------
    level : float
        Constant term.
    curves : tuple of Curve
        One for each of `FEATURES`.
    usual, own : float
        The usual difficulty of frames, and the weight of a frame's deviation from it in wide gaps.
    """

    level: float
    curves: tuple[Curve, ...]
    usual: float = 0.0
    own: float = 0.0

    def logarithms(self, features: NDArray[np.floating]) -> NDArray[np.float64]:
        """Logarithms of expected errors as shares of depth, for features (N, 13), in a frame of usual difficulty."""
        curves = [np.array(curve) for curve in self.curves]
        most = max(2, *(curve.shape[1] for curve in curves))
        bends = np.stack([np.pad(curve, ((0, 0), (0, most - curve.shape[1])), "edge") for curve in curves])
        return self.level + _sum_of_curves(np.ascontiguousarray(features.T), bends)

    def shares(self, features: NDArray[np.floating], difficulty: float | None = None) -> NDArray[np.float64]:
        """Expected errors as shares of depth, at least `FLOOR` and at most 1.

        Parameters
        ----------
        features : ndarray of float, shape (N, 13)
            See `error_features`.
        difficulty : float, optional
            Difficulty of the frame (`frame_difficulty`); the usual one if unknown.
        """
        total = self.logarithms(features)
        if difficulty is not None:
            total += self.own * unusual(difficulty, self.usual) * gap_weight(features)
        return np.exp(np.clip(total, np.log(FLOOR), 0.0))


def _add_curves(features: NDArray[np.floating], bends: NDArray[np.float64]) -> NDArray[np.float64]:
    total = np.zeros(features.shape[1])
    for column in range(features.shape[0]):
        knots, values = bends[column]
        for i in range(total.size):
            feature, k = features[column, i], 1
            while k < knots.size - 1 and feature >= knots[k]:
                k += 1
            share = 1.0  # beyond the last knot
            if feature < knots[k]:
                share = max((feature - knots[k - 1]) / (knots[k] - knots[k - 1]), 0.0)
            total[i] += values[k - 1] + share * (values[k] - values[k - 1])
    return total


@compiled(_add_curves)
def _sum_of_curves(features: NDArray[np.floating], bends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum over features (13, N) of their curves, given by knots and values (13, 2, K), of which the last may repeat."""
    return np.sum([np.interp(column, *curve) for column, curve in zip(features, bends, strict=True)], axis=0)


def unusual(difficulty: float, usual: float) -> float:
    """Deviation of a difficulty from the usual one, clipped since the test is coarse."""
    return min(max(difficulty - usual, -_MAX_DEVIATION), _MAX_DEVIATION)


def gap_weight(features: NDArray[np.floating]) -> NDArray[np.floating]:
    """Weight of a frame's difficulty: from 0 in narrow gaps to 1 in wide ones."""
    return np.clip((features[:, _GAP] - _NARROW) / (_WIDE - _NARROW), 0.0, 1.0)
