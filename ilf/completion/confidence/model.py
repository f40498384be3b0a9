"""The law by which expected errors follow from what can be seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .features import FEATURES, FLOOR

WITHIN = 0.6827
"""Share of errors that is to lie within the expected error: that of one standard deviation."""

WITHIN_TWICE = 0.9545
"""Share of errors that is to lie within twice the expected error: that of two standard deviations."""

_GAP = list(FEATURES).index("gap")
_NARROW, _WIDE = np.log(2.0), np.log(8.0)
"""Logarithms of the width [px] of gaps up to which a frame's difficulty does not count, and from which in full."""

_MOST_UNUSUAL = 0.5
"""No frame counts as more, or less, difficult than usual by more than that."""


@dataclass(frozen=True)
class Curve:
    """What one of the features adds to the logarithm of the expected error: linear between knots, level beyond them."""

    knots: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, feature: NDArray[np.floating]) -> NDArray[np.float64]:
        """What is added where the feature is this."""
        return np.interp(feature, self.knots, self.values)


@dataclass(frozen=True)
class ErrorModel:
    """Logarithm of the expected error, as a share of depth: a sum of curves.

    Attributes
    ----------
    level : float
        What all pixels have in common.
    curves : tuple of Curve
        One for each of `FEATURES`.
    usual, own : float
        The usual difficulty of frames, and how much of what a frame's own is above it is added in wide gaps.
    """

    level: float
    curves: tuple[Curve, ...]
    usual: float = 0.0
    own: float = 0.0

    def logarithms(self, features: NDArray[np.floating]) -> NDArray[np.float64]:
        """Of the expected errors as shares of depth, of features (N, 13), in a frame of usual difficulty."""
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
            Of the frame (`frame_difficulty`); the usual one if it is not known.
        """
        total = self.logarithms(features)
        if difficulty is not None:
            total += self.own * unusual(difficulty, self.usual) * wideness(features)
        return np.exp(np.clip(total, np.log(FLOOR), 0.0))


def unusual(difficulty: float, usual: float) -> float:
    """How far a difficulty is above the usual one, as far as a test that is so coarse is believed."""
    return min(max(difficulty - usual, -_MOST_UNUSUAL), _MOST_UNUSUAL)


def wideness(features: NDArray[np.floating]) -> NDArray[np.floating]:
    """How much a frame's difficulty counts: from 0 in narrow gaps to 1 in wide ones."""
    return np.clip((features[:, _GAP] - _NARROW) / (_WIDE - _NARROW), 0.0, 1.0)
