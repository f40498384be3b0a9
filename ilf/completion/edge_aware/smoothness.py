"""An energy of samples, slopes and bending on a pixel grid, and its minimisation.

    E(u) = sum c (u - s)^2 + sum w_1 (first differences)^2 + sum w_2 (second differences)^2

along both axes. Its minimum is the fixed point of ILF, u <- S(samples where known, u elsewhere), with the low-pass
filter S = (1 + L)^-1, where L is the operator of the two smoothness terms: lower weights at edges make the filter
edge-aware.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._runtime.compiling import inner
from ..banded import solve_grid
from . import kernels
from .kernels import Sums

Array = NDArray[np.float32]

# The energy, and its minimisation by conjugate gradients or a direct solution.

_CONVERGED = 1e-14
"""Share of the first squared residual below which no further precision can be gained."""

_CELLS_AT_A_TIME = 2**18
"""Steps on small grids are made several at a time, up to this total of cells: about half a millisecond's work."""


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of first and second differences.

    Attributes
    ----------
    framed : ndarray of float32, shape (4, H + 4, W)
        Weights of first differences along x and y and of second differences along x and y, at the first pixel of each;
        0 where there is no such difference, and in the two padding rows above and below.
    """

    framed: Array

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> Weights:
        """All 0, to be filled in."""
        return cls(np.zeros((4, shape[0] + 4, shape[1]), np.float32))

    @property
    def slope_x(self) -> Array:
        """Shape (H, W - 1)."""
        return self.framed[0, 2:-2, :-1]

    @property
    def slope_y(self) -> Array:
        """Shape (H - 1, W)."""
        return self.framed[1, 2:-3]

    @property
    def bend_x(self) -> Array:
        """Shape (H, W - 2)."""
        return self.framed[2, 2:-2, :-2]

    @property
    def bend_y(self) -> Array:
        """Shape (H - 2, W)."""
        return self.framed[3, 2:-4]

    def bent(self, times: np.float32) -> Weights:
        """Weights with those of second differences multiplied by a factor."""
        return Weights(self.framed * np.array([1, 1, times, times], np.float32)[:, None, None])

    def weaken(self, u: Array, scale: Array, slope_jumps: float) -> None:
        """Reduce them with Cauchy's function, in place, where differences of u are far above the scale.

        Parameters
        ----------
        u : ndarray, shape (H, W)
        scale : ndarray, shape (H, W)
            Second difference at which the weight is halved, in the unit of u.
        slope_jumps : float
            The same for first differences, in units of `scale`.
        """
        kernels.weaken_links(self.framed, u, scale, np.float32(slope_jumps))


def make_weights(
    smooth: Array,
    slope: float,
    bending: float,
    creases: Array | None = None,
    out: Weights | None = None,
) -> Weights:
    """Make weights from the smoothness of pixels.

    Parameters
    ----------
    smooth : ndarray of float32, shape (H, W)
        1 where a pixel is fully linked to its neighbours, 0 where it is separated from them. A difference has the
        smoothness of the least smooth of its pixels.
    slope, bending : float
        Weights of the two terms.
    creases : ndarray of float32, shape (H, W), optional
        Share by which the second difference around a pixel counts less: 1 at a crease, where the surface may bend, but
        not tear.
    out : Weights, optional
        Weights of this grid that are no longer needed; overwritten, to avoid allocation.
    """
    made = out or Weights.none(smooth.shape)
    kernels.link(smooth, np.float32(slope), np.float32(bending), creases, made.framed)
    return made


class SmoothnessEnergy:
    """The energy on one grid.

    Parameters
    ----------
    counts : ndarray of float32, shape (H, W)
        Weight c of the samples; 0 where there is none, but positive somewhere in every connected part.
    totals : ndarray of float32, shape (H, W)
        c times the sample.
    weights : Weights
    """

    def __init__(self, counts: Array, totals: Array, weights: Weights) -> None:
        self._counts = counts
        self._totals = totals
        self._weights = weights

    def descend(
        self, u: Array, inputs: tuple[Array, Array, Array, Array], steady: float, limit: int
    ) -> Iterator[tuple[Array, Sums]]:
        """Minimise by conjugate gradients with a diagonal preconditioner, from u on; yields the approximations and the
        sums of their steps.

        Ends after `limit` steps, when they are steady, or at the precision of float32. Steps on small grids are made
        several at a time.

        Parameters
        ----------
        u : ndarray of float32, shape (H, W)
        inputs : tuple of ndarray of float32, shape (H, W)
            For the sums: number of the block's pixels in every cell, the trend that the surface is relative to, weights
            of the samples in the misfit, and weights times samples.
        steady : float
            Sum of squared changes below which the descent is steady.
        limit : int
        """
        weights, direction = self._weights.framed, kernels.framed(u)
        inverse = self._diagonal(np.float32)
        np.reciprocal(inverse, out=inverse)
        residual = np.empty_like(u)
        kernels.pull(self._counts, weights, direction, residual)
        direction[:] = 0
        np.subtract(self._totals, residual, out=residual)
        size, ratio = inner(residual, inverse * residual), 0.0
        least, changes = _CONVERGED * size, math.inf
        while limit > 0 and size > least and changes >= steady:
            many = min(limit, max(1, _CELLS_AT_A_TIME // u.size))
            found, sums = np.empty((many, *u.shape), np.float32), np.empty((many, len(Sums._fields)))
            state, sizes = (direction, residual), (size, ratio, least)
            steps, size, ratio = kernels.descend(
                self._counts, weights, inverse, state, sizes, inputs, steady, u, found, sums
            )
            limit -= steps
            for u, (changes, *others) in zip(found[:steps], sums.tolist(), strict=False):
                yield u, Sums(changes, *others)

    def minimum(self) -> Array:
        """The exact minimum, by a direct solution; for small grids."""
        weights = self._weights
        shape = self._counts.shape
        along_x = _couplings(weights.slope_x, weights.bend_x, shape)
        along_y = _couplings(weights.slope_y.T, weights.bend_y.T, shape[::-1])
        wanted = self._totals.astype(np.float64)[None]
        found = solve_grid(self._diagonal(np.float64), along_x, (along_y[0].T, along_y[1].T), wanted)
        return found[0].astype(np.float32)

    def _diagonal(self, dtype: type[np.floating]) -> NDArray[Any]:
        result = self._counts.astype(dtype)
        kernels.spread(self._weights.framed, result)
        return result


def _couplings(slope: Array, bend: Array, shape: tuple[int, ...]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Matrix entries between a pixel and the next, and the one after that, along the second axis."""
    near, far = np.zeros(shape), np.zeros(shape)
    near[:, :-1] -= slope
    near[:, :-2] -= 2 * bend
    near[:, 1:-1] -= 2 * bend
    far[:, :-2] += bend
    return near, far
