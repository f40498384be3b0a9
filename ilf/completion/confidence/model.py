"""The model of the expected error: from features of a filled pixel to its error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True)
class Curve:
    """Contribution of one feature to the logarithm of the expected error: linear between knots, constant beyond."""

    knots: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, feature: NDArray[np.floating]) -> NDArray[np.float64]:
        """The contribution for values of the feature."""
        return np.interp(feature, self.knots, self.values)


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
        total = np.full(len(features), self.level)
        for column, curve in zip(features.T, self.curves, strict=True):
            total += curve.at(column)
        return total

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


def unusual(difficulty: float, usual: float) -> float:
    """Deviation of a difficulty from the usual one, clipped since the test is coarse."""
    return min(max(difficulty - usual, -_MAX_DEVIATION), _MAX_DEVIATION)


def gap_weight(features: NDArray[np.floating]) -> NDArray[np.floating]:
    """Weight of a frame's difficulty: from 0 in narrow gaps to 1 in wide ones."""
    return np.clip((features[:, _GAP] - _NARROW) / (_WIDE - _NARROW), 0.0, 1.0)
