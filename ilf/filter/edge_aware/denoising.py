"""Taking noise off known depth, in the mode fill+denoise: as stiff as the noise calls for, and over no jump.

From the raw depth on, the surface is made stiffer from round to round. How rough noise can make it after each is known;
where it bends or steps by more than that, it lets go in the next. So jumps of known depth are edges, and show in ever
finer detail as the noise around them goes down.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ...parameters import Parameters
from .noise import Noise
from .smoothness import SmoothnessEnergy, Weights

Array = NDArray[np.float32]

_ROUNDS = ((5, 4), (30, 6), (200, 16), (1000, 28))
"""In every round, how many times more bending weighs than it does to fill, and the steps, at most."""

_EXPLAINED = 3.0
"""A surface bends by more than noise explains at so many deviations of what the noise leaves of itself there."""

_SLOPE_JUMPS = 8.0
"""First differences let go at so many times the second difference that does."""

_FILLED = 0.1
"""What missing depth has been filled with counts so much, a known pixel being 1."""

_BORNE_OUT, _SQUARES = 5.0, (3, 7)
"""Beside a trend that explains all of the known depth, what is left stays where its mean over squares of one of these
sides is so many deviations of noise."""

_STEADY = 0.01
"""A round is steady if it changes depth by less than this share of its noise."""


@dataclass(frozen=True, eq=False)
class Denoising:
    """The known depth of a window, and how noisy it is.

    Attributes
    ----------
    known : ndarray of bool, shape (h, w)
    samples : ndarray of float32, shape (h, w)
        Known depth less the trend [m]; 0 where there is none.
    deviation : ndarray of float32, shape (h, w)
        Standard deviation of its noise [m].
    grain : float
        As `Noise` has it.
    bending : float
        Weight of bending that the rounds' are multiples of.
    smoothness : float
        Factor on all weights.
    lets_go : bool
        Whether the surface lets go anywhere.
    explained : bool
        Whether the trend explains all of the known depth, up to its noise.
    """

    known: NDArray[np.bool_]
    samples: Array
    deviation: Array
    grain: float
    bending: float
    smoothness: float
    lets_go: bool
    explained: bool

    @classmethod
    def of(cls, depth: Array, trend: Array, noise: Noise, parameters: Parameters, explained: bool) -> Denoising:
        """Of depth [m], NaN = missing, and a trend [m], which explains it or does not."""
        known = np.isfinite(depth)
        return cls(
            known=known,
            samples=np.where(known, depth - trend, np.float32(0)),
            deviation=noise.deviation(np.where(known, depth, trend)),
            grain=noise.grain,
            bending=parameters.bending_weight,
            smoothness=parameters.smoothness,
            lets_go=parameters.jump_share > 0,
            explained=explained,
        )

    def start(self, filled: Array | None) -> Array:
        """The known depth less the trend, and where it is missing what it has been filled with; None is the trend."""
        return self.samples if filled is None else np.where(self.known, self.samples, filled)

    def rounds(self, filled: Array | None, weights: Weights) -> Iterator[Round]:
        """The rounds, from what missing depth has been filled with, less the trend, and the weights of filling."""
        counts = np.full(self.known.shape, _FILLED, np.float32)
        if self.known.any():
            usual = np.median(self.deviation[self.known])
            counts[self.known] = np.square(usual / self.deviation[self.known])
        totals = counts * self.start(filled)
        before = _ROUNDS[0][0]
        for times, steps in _ROUNDS:
            stiff = weights.bent(np.float32(times * self.grain))
            scale = None
            if self.lets_go:  # later where more smoothness is asked for than noise calls for
                scale = np.float32(_EXPLAINED * self.smoothness) * self._bent_by_noise(before)
            yield Round(counts, totals, stiff, scale, steps)
            before = times

    def cleared(self, u: Array) -> Array:
        """The surface after the last round, beside a trend that explains it less what noise alone may have left."""
        if not self.explained:
            return u
        borne_out = np.zeros_like(u)
        relative = self.samples / self.deviation
        for side in _SQUARES:
            mean, share = (cv2.blur(values, (side, side)) for values in (relative, self.known.astype(np.float32)))
            pixels = share * np.float32(side * side)
            expected = np.sqrt(pixels * np.minimum(pixels, np.float32(self.grain))) / np.float32(side * side)
            np.maximum(borne_out, np.abs(mean) / np.maximum(expected, np.float32(1e-6)), out=borne_out)
        ratio = np.float32(_BORNE_OUT) / np.maximum(borne_out, np.float32(1e-6))
        return u * np.maximum(1 - ratio * ratio, 0)

    @property
    def least(self) -> float:
        """Change [m] below which a round is steady."""
        return _STEADY * float(np.median(self.deviation))

    # Noise whose power is one over a surface that weights w make stiff against bending: with frequencies k, what is
    # left of it is 1 / (1 + w k^4), so its variance is 1 / (16 w^(1/2)), that of second differences 1 / (16 w^(3/2)).

    def _bent_by_noise(self, times: float) -> Array:
        return self._power() * (self._stiffness(times) ** -0.75 / 4)

    def _power(self) -> Array:
        return self.deviation * np.float32(math.sqrt(self.grain))

    def _stiffness(self, times: float) -> np.float32:
        # weights that are asked to be larger or smaller do not change what counts as a jump
        return np.float32(max(self.bending * times * self.grain, 1e-6))


@dataclass(frozen=True, eq=False)
class Round:
    """One round: samples, weights of its own, where they let go if they do, and steps at most."""

    counts: Array
    totals: Array
    weights: Weights
    scale: Array | None
    steps: int

    def energy(self, u: Array) -> SmoothnessEnergy:
        """What the round minimises, from the surface at its start; once."""
        if self.scale is not None:
            self.weights.loosen(u, self.scale, _SLOPE_JUMPS)
        return SmoothnessEnergy(self.counts, self.totals, self.weights)
